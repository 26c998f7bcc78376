"""What the reference paper's assumptions cost, cause by cause."""
