"""The flights of a ledger on screens: rows, cards, logs, tags, removal."""
