"""The posterior predictive of the next flight: draws of the apogee, averaged, widened and calibrated."""
