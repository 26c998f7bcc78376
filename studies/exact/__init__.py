"""The exact posterior of simulated flights, all that is random in them integrated out."""
