"""Studies of the methods, beside the program: the reference paper, exact posteriors, the histories of rockets."""
