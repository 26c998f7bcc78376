"""The use cases: one function for each thing that a flyer does, over the ledger and the core."""
