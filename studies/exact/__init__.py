"""The exact posterior of simulated flights with all random inputs integrated out."""
