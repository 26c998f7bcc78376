"""What the page Home shows and asks."""
