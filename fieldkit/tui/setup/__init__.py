"""What a flyer keeps: sites, motors, rockets, settings."""
