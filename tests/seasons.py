"""Simulated seasons of one rocket for tests and benchmarks."""

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import forecast_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of

MOTORS = ("F24", "F39", "E35")


def season(
    rng: np.random.Generator,
    recorded: tuple[str, ...],
    count: int = 12,
    wind: float | None = None,
    scatter: float = 0.0,
) -> list[tuple[Flight, Found]]:
    """Flights of a rocket with high drag on three motors with some readouts; `scatter` is the standard deviation of log
    apogees in addition to drag and thrust."""
    plans = [
        Flight(
            str(i), "Test", "A", MOTORS[i % 3], dry_mass=0.322, diameter=0.066, delay=10.0, rail_length=1.2, wind=wind
        )
        for i in range(count)
    ]
    found = [catalogue().resolve(plan.motor) for plan in plans]
    model = forecast_model(history_of(plans, found))
    truth = np.array([[term.mean + 0.7 * term.sd * (term.bends == "drag") for term in model.terms]])
    single = {"drag": 0.03 * rng.normal(size=(1, count)), "thrust": 0.025 * rng.normal(size=(1, count))}
    readings = shown(model, truth, single)
    noisy = {name: readings[name][0] * np.exp(0.01 * rng.normal(size=count)) for name in recorded}
    if scatter:
        noisy["apogee"] = noisy["apogee"] * np.exp(scatter * rng.normal(size=count))
    rows = [
        plan.with_changes(**{name: float(values[i]) for name, values in noisy.items()}) for i, plan in enumerate(plans)
    ]
    return list(zip(rows, found, strict=True))
