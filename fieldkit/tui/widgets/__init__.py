"""Widgets that several pages use: tables, plots, bars, cards, dialogs."""
