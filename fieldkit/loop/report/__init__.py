"""A closed loop as a page to keep, print or send: one file, pictures inside."""
