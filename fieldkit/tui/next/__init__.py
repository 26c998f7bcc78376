"""The next flight on screens: motors, plans, forecasts, decisions."""
