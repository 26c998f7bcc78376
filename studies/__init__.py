"""Studies of the methods, separate from the program: exact posteriors, causes of the reference paper's bias, the
histories of rockets."""
