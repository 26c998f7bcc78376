"""How good forecasts were: rivals of the model, and histories forecast forward in time."""
