"""Contents of the page Home."""
