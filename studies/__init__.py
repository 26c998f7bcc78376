"""Studies of the methods, separate from the program: the reference paper, exact posteriors, the histories of
rockets."""
