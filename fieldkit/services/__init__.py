"""The use cases: one function per user action, over the ledger and the core."""
