"""Dialogs and text before and after an import."""
