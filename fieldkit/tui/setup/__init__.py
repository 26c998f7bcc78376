"""A flyer's sites, motors, rockets and settings."""
