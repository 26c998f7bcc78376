"""The air of a planned flight: its density, and how it biases a barometric altimeter, two separate effects of heat."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from fieldkit.flight import CONDITIONS, Flight
from fieldkit.physics.atmosphere import altimeter_gain, density_altitude, pad_air
from fieldkit.quantities import SYSTEMS, density, written

OTHER_AIR: Mapping[str, tuple[str, Mapping[str, str], str]] = MappingProxyType(
    {
        "elevation": ("m", {"m": "300 m higher", "ft": "1,000 ft higher"}, "shows 0.5 to 1.2% more"),
        "temperature": ("c", {"c": "10 °C warmer", "f": "18 °F warmer"}, "shows 2 to 3% less"),
        "pressure": ("hpa", {"hpa": "10 hPa off", "inhg": "0.3 inHg off"}, "up to 0.2% either way"),
    }
)
"""By condition, its unit in SI, a step by unit, and how much it changes the apogee shown of F24-4W (322 g, 66 mm), A8-3
(40 g, 25 mm) and C6-5 (60 g, 25 mm), with a Cd of 0.6."""


@dataclass(frozen=True, slots=True)
class PadAir:
    """Density at the pad [kg/m^3], density altitude [m], ratio of the altimeter's reading to the true height [1], and
    the conditions that were not given and default to the standard atmosphere."""

    density: float
    density_altitude: float
    gain: float
    assumed: tuple[str, ...]

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "density_kg_m3": self.density,
            "density_altitude_m": self.density_altitude,
            "shown_over_true": self.gain,
            "assumed_standard": list(self.assumed),
        }

    @property
    def altimeter(self) -> str:
        """By how much an altimeter reads too high or too low in it: `altimeter reads 6.4% low`."""
        off = 100 * (self.gain - 1)
        reads = "reads correctly" if abs(off) < 0.05 else f"reads {abs(off):.1f}% {'high' if off > 0 else 'low'}"
        return f"altimeter {reads}"

    def words(self, system: str = "SI") -> str:
        """A one-line summary: `1.146 kg/m³ at the pad (density altitude 690 m); altimeter reads 6.4% low`."""
        higher = written(self.density_altitude, "m", system, 0)
        text = f"{density(self.density, system)} at the pad (density altitude {higher}); {self.altimeter}"
        return f"{text}; standard values for {', '.join(self.assumed)}" if self.assumed else text

    def other(self, system: str = "SI") -> str:
        """By how much other air than was assumed changes what the altimeter shows; empty if nothing was assumed."""
        return ", ".join(_other(name, system) for name in self.assumed)


def air_of(plan: Flight) -> PadAir:
    """The air of a plan; conditions not given default to the standard atmosphere at its elevation, and to no wind."""
    return _air(plan.site_elevation, plan.temperature, plan.pressure, plan.humidity)


def _other(name: str, system: str) -> str:
    unit, step, changes = OTHER_AIR[name]
    return f"{step[SYSTEMS[system].get(unit, unit)]} {changes}"


@lru_cache(maxsize=64)
def _air(elevation: float | None, temperature: float | None, pressure: float | None, humidity: float | None) -> PadAir:
    """Cached, because hundreds of plans share the same air."""
    known = [np.array([np.nan if value is None else value]) for value in (elevation, temperature, pressure, humidity)]
    density = pad_air(*known).density
    given = {"elevation": elevation, "temperature": temperature, "pressure": pressure}
    return PadAir(
        density=float(density[0]),
        density_altitude=float(density_altitude(density)[0]),
        gain=float(altimeter_gain(*known[:3])[0]),
        assumed=tuple(name for name, value in given.items() if value is None),
    )


def conditions(plan: Flight) -> dict[str, float]:
    """The conditions that a plan declares, by column, in the column's unit: `wind_mps`."""
    return {
        column.header: float(column.render(value))
        for column in CONDITIONS
        if (value := plan.number(column.name)) is not None
    }
