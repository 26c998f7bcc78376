"""Patterns that no effect represents, for simulated histories."""

from collections.abc import Callable, Sequence

import numpy as np

from fieldkit.physics.setups import recorded
from fieldkit.shapes import Array, Float
from studies.quick_network.drawn_rockets import DrawnRocket

_PATTERN_SIZES = {"drag": (0.08, 0.6), "mass": (0.04, 0.3), "thrust": (0.03, 0.15)}
"""Bounds of the size of a pattern in the logarithm of each property. [1]"""


def unexplained_pattern(rng: np.random.Generator, rocket: DrawnRocket) -> dict[str, Float[Array, "flight"]]:
    """A shift of log drag, log mass or log thrust with a recorded condition or with the flight index. [1]"""
    kinds: Sequence[Callable[[np.random.Generator, DrawnRocket], Array]] = (_step, _day, _periodic, _smooth, _smooth)
    shape = kinds[int(rng.integers(len(kinds)))](rng, rocket)
    bends = str(rng.choice(list(_PATTERN_SIZES), p=[0.6, 0.25, 0.15]))
    low, high = _PATTERN_SIZES[bends]
    size = float(np.exp(rng.uniform(np.log(low), np.log(high)))) * float(rng.choice([-0.7, 1.0], p=[0.3, 0.7]))
    return {bends: size * shape}


def _step(rng: np.random.Generator, rocket: DrawnRocket) -> Array:
    count = len(rocket.used_in_fit)
    return np.where(np.arange(count + 1) >= rng.integers(1, count), 1.0, 0.0)


def _day(rng: np.random.Generator, rocket: DrawnRocket) -> Array:
    """A single day, shared by its flights; four flights in a row count as a day if no dates are recorded."""
    days = [
        flight.date_time.date().isoformat() if flight.date_time else str(i // 4)
        for i, flight in enumerate(rocket.flights)
    ]
    bad = days[int(rng.integers(len(days) - 1))]
    return np.array([day == bad for day in days], float)


def _periodic(rng: np.random.Generator, rocket: DrawnRocket) -> Array:
    every = int(rng.integers(2, 5))
    return np.where(np.arange(len(rocket.flights)) % every == rng.integers(every), 1.0, 0.0)


def _smooth(rng: np.random.Generator, rocket: DrawnRocket) -> Array:
    """A smooth random function of the hour, the flight index or a condition, with standard deviation 0.5."""
    hours = np.array([f.date_time.hour + f.date_time.minute / 60 if f.date_time else np.nan for f in rocket.flights])
    columns = [hours, np.arange(len(hours), dtype=float)]
    columns += [recorded(rocket.flights, name) for name in ("temperature", "wind", "pressure")]
    usable = [column for column in columns if np.isfinite(column).all() and np.ptp(column) > 0]
    along = usable[int(rng.integers(len(usable)))]
    along = (along - along.mean()) / along.std()
    waves = rng.normal(size=(3, 1)) * along * rng.uniform(0.3, 1.2) + rng.uniform(0, 2 * np.pi, (3, 1))
    shape = (rng.normal(size=(3, 1)) * np.cos(waves)).sum(axis=0)
    return np.asarray(0.5 * (shape - shape.mean()) / max(float(shape.std()), 1e-6))
