"""What the loop shows: panels, text, plots."""
