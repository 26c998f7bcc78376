"""Making the ensembles that the field runs. The only home of torch; the extra `fieldkit[train]`."""
