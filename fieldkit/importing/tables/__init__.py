"""What parsers are made of: text, rows and columns, clocks, what a header says, units that physics settles."""
