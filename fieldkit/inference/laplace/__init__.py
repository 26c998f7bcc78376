"""The hierarchical fit: a Laplace approximation of the posterior, leave-one-out forecasts, outliers."""
