"""The fault bench: what is left of a ledger after kills, full disks, two writers, odd clocks and damaged files."""
