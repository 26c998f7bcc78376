"""What the further columns of a flight say about its climb."""

from dataclasses import dataclass

from fieldkit.flight.flight import Flight
from fieldkit.flight.recovery import OPENING_TIME, UNCERTAIN_WEATHER

_OF_THE_CLIMB = ("wind_aloft", "wind_aloft_height", "wind_aloft_turn", "opening_time")


@dataclass(frozen=True, slots=True)
class LaunchConditions:
    """What the further columns of a flight say about its climb, None if not recorded.

    `rail_direction` is 0 into the wind, pi away from it and pi/2 across it to the right [rad]; `wind_aloft` [m/s] at
    `wind_aloft_height` [m] is turned to the right of the wind at the pad by `wind_aloft_turn` [rad]. `opening_time` is
    the time from the charge to an open parachute [s], `stability` the static margin [body diameters], and `dual`
    whether a main opens after a drogue. `weather_sd` has the standard deviation of each of `UNCERTAIN_WEATHER`, 0 if
    not recorded. [K, Pa, m/s]
    """

    rail_direction: float = 0.0
    wind_aloft: float | None = None
    wind_aloft_height: float | None = None
    wind_aloft_turn: float = 0.0
    opening_time: float = OPENING_TIME
    stability: float | None = None
    dual: bool = False
    weather_sd: tuple[float, ...] = (0.0, 0.0, 0.0)


AS_USUAL = LaunchConditions()
"""The conditions of a flight without further columns."""


def launch_conditions(flight: Flight) -> LaunchConditions:
    """The further columns of a flight about its climb; as usual if one of them cannot be read, which `check_conditions`
    and `fieldkit.flight.plausibility.implausible` find before a flight or a plan is simulated."""
    columns = flight.columns
    if not columns.texts or _unread(flight):
        return AS_USUAL
    numbers = columns.numbers
    return LaunchConditions(
        columns.rail_direction if flight.rail_angle else 0.0,
        numbers.get("wind_aloft"),
        numbers.get("wind_aloft_height"),
        numbers.get("wind_aloft_turn", 0.0),
        max(numbers.get("opening_time", OPENING_TIME), 0.0),
        columns.stability,
        "main_altitude" in numbers or "main_altitude" in columns.problems,
        tuple([_weather_sd(flight, name, most) for name, most in UNCERTAIN_WEATHER.items()]),
    )


def check_conditions(flight: Flight) -> None:
    """Raise BadValue for a wind aloft, an opening time or the direction of a tilted rail that cannot be read."""
    flight.columns.check(*_unread(flight))


def _unread(flight: Flight) -> list[str]:
    """The columns about the climb that cannot be read; the direction of a vertical rail does not matter."""
    columns, names = flight.columns, (*_OF_THE_CLIMB, *(["rail_direction"] if flight.rail_angle else []))
    return [name for name in names if name in columns.problems and name not in columns.numbers]


def _weather_sd(flight: Flight, name: str, most: float) -> float:
    """The recorded standard deviation of a recorded condition, at most that of ignorance; 0 without one."""
    sd = flight.columns.sd.get(name) if flight.number(name) is not None else None
    return min(sd, most) if sd is not None and sd > 0 else 0.0
