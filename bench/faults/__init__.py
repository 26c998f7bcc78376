"""The fault bench: the state of a ledger after kills, full disks, two writers, wrong clocks and damaged files."""
