"""Contents of the Home page."""
