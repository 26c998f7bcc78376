"""The air a plan flies in, and what a barometric altimeter makes of it: two things that hot days part."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from fieldkit.flight import CONDITIONS, Flight
from fieldkit.physics.atmosphere import altimeter_gain, density_altitude, pad_air
from fieldkit.quantities import density, written

WEATHER = ("temperature", "pressure", "humidity", "wind")
"""The conditions that belong to the day. [names of columns]"""


@dataclass(frozen=True, slots=True)
class PadAir:
    """Density at the pad [kg/m^3], the height where the standard atmosphere is as thin [m], what the altimeter shows
    over the true height [1], and the conditions that were not given and are the standard's."""

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

    def words(self, system: str = "SI") -> str:
        """In a line: `1.146 kg/m³ at the pad (density altitude 690 m); altimeter reads 6.4% low`."""
        higher = written(self.density_altitude, "m", system, 0)
        off = 100 * (self.gain - 1)
        reads = "reads correctly" if abs(off) < 0.05 else f"reads {abs(off):.1f}% {'high' if off > 0 else 'low'}"
        text = f"{density(self.density, system)} at the pad (density altitude {higher})"
        text += f"; altimeter {reads}"
        return f"{text}; standard values for {', '.join(self.assumed)}" if self.assumed else text


def air_of(plan: Flight) -> PadAir:
    """The air of a plan; what was not given is the standard atmosphere's at its elevation, and still."""
    return _air(plan.site_elevation, plan.temperature, plan.pressure, plan.humidity)


@lru_cache(maxsize=64)
def _air(elevation: float | None, temperature: float | None, pressure: float | None, humidity: float | None) -> PadAir:
    """Hundreds of plans fly in the same air."""
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
    """The conditions that a plan declares, by column, as written there: `wind_mps`."""
    return {
        column.header: float(column.render(value))
        for column in CONDITIONS
        if (value := plan.number(column.name)) is not None
    }
