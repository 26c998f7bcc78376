"""Planning the next flight: motor, delay, ballast, safety and contest points, all from the calibrated model."""
