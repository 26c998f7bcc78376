"""Pages to keep, print or send: the loop, a flight, a day, a rocket, and how good forecasts were."""
