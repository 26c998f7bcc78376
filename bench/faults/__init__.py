"""The fault bench: what is left of a ledger after kills, full discs, two writers, odd clocks and damaged files."""
