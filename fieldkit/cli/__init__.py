"""The command line: each command reads arguments, calls one function of the core and prints one thing."""
