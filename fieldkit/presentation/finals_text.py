"""The table of finals: for each target what to weigh and how large the parachute is to be, on one card."""

from collections.abc import Iterator, Sequence

from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.planning.air import air_of
from fieldkit.planning.contest import Season
from fieldkit.planning.finals import Together
from fieldkit.units import FOOT, ZERO_CELSIUS

HEADERS = ("target ft", "dry g", "lift-off g", "parachute", "apogee ft", "seconds", "points")


def finals_rows(table: Sequence[Together], found: Found) -> list[tuple[str, ...]]:
    """A row for each target."""
    return [
        (
            f"{one.target / FOOT:.0f}",
            f"{one.mass * 1e3:.0f}",
            f"{(one.mass + found.motor.loaded_mass) * 1e3:.0f}",
            f"{one.area:.0%}{'*' if one.at_edge else ''}",
            f"{one.apogee[0] / FOOT:.0f}-{one.apogee[2] / FOOT:.0f}",
            f"{one.duration[0]:.0f}-{one.duration[2]:.0f}",
            f"{one.points:.0f}",
        )
        for one in table
    ]


def finals_heading(plan: Flight, found: Found, rule: Season) -> Iterator[str]:
    """Rocket, motor, season and the day's weather, over the table."""
    name = " ".join(part for part in (plan.rocket, plan.config) if part)
    opens, closes = rule.window
    motor = f"{found.motor.maker} {found.motor.designation}"
    yield f"{name} on {motor}, season {rule.year}, window {opens:g} to {closes:g} s"
    temperature = "standard" if plan.temperature is None else f"{plan.temperature - ZERO_CELSIUS:.0f} °C"
    wind = "not given" if plan.wind is None else f"{plan.wind:.1f} m/s"
    yield f"temperature {temperature}, wind {wind}; {air_of(plan).words()}"


FINALS_NOTES = (
    "parachute: area relative to the one flown. *: at the limit of the masses and areas tried; a wider range may be "
    "better. "
    "apogee, seconds: 5 to 95 %. points: mean per flight.",
    "Weigh on the pad; the altimeter's reading counts.",
)
