"""What an import shows before and after it."""
