"""A closed loop as a page: one file, pictures inside."""
