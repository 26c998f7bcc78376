"""From what flights taught to the next flight, and back."""
