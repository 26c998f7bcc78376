"""Training of the ensembles: the only home of torch."""
