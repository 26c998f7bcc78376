"""Which values a flight can have at all, and which values contradict each other.

`fieldkit.flight.limits` has the bounds beyond which a number must be a typing error. This module has the bounds of
physics, and the relations that the ten readouts of a flight obey. A value that no rocket can reach on the flight's
motor is `implausible`: the flight stays in the ledger, is reported, and is left out of every fit.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from statistics import median
from types import MappingProxyType
from typing import Protocol

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, COLUMNS, READOUTS, Column, Flight
from fieldkit.flight.limits import check
from fieldkit.flight.recovery import IN_EVERY_FIT
from fieldkit.flight.unit_slips import unit_slip
from fieldkit.messages import TextWithAmounts, marked, message, of_column

IDENTITY = (0.9, 1.1)
"""Range of top speed over (average acceleration × burn time); outside it, a value is mistyped. [1]

The device averages the acceleration over the burn and net of gravity, so the ratio is 1 except for rounding. Of 116
flights in one ledger, all but one were within 0.905 to 1.055.
"""

DESCENT = (0.8, 1.25)
"""Range of ejection altitude over (descent speed × time from ejection to landing); outside it, a value is mistyped. [1]

The device averages the speed from ejection to landing, so the ratio is 1 except for rounding and for the fall before
the parachute opens. Of 48 flights in one journal, all were within 0.94 to 1.17.
"""

PLAUSIBLE_RATIO = (0.5, 2.0)
"""Range of a readout over the median for the same rocket and motor; outside it, a value is mistyped. [1]

Mass, wind and motor lots change a readout by less; an extra digit, or feet entered as meters, by more.
"""
USUAL_SD = 0.1
"""Standard deviation of the log ratio of a readout to the median for the same rocket and motor. [1]"""
MOST_TIMES = 1000
"""Largest ratio that is stated as such. [1]"""
BUILD_RATIOS = {"dry_mass": PLAUSIBLE_RATIO, "diameter": (0.95, 1.05)}
"""Ranges of a plan's mass and diameter over those flown last; outside them, a value is mistyped, or the rocket another
one: a body is measured to a few percent. [1]"""
SIGNED_READOUTS = ("apogee_to_eject",)
"""Readouts that can be around zero, which a ratio cannot check."""

NO_COAST = "a coast of 0 s shows that the device did not detect burnout"
"""Why a readout counted from burnout is not used."""

IMPULSE_SCATTER = 0.067
"""Largest standard deviation of the total impulse of a certified motor, NFPA 1125. [1]"""
MAX_THRUST_RATIO = 1 + 3 * IMPULSE_SCATTER
"""Largest impulse or thrust of a motor, relative to its certified curve: three standard deviations. [1]"""
READ_TOO_HIGH = 1.2
"""Largest ratio of an altimeter's reading to the true value: the standard atmosphere in air at -35 °C. [1]"""
MIN_BURN_FRACTION = 0.5
"""Smallest fraction of a motor's burn in which a rocket gains speed. [1]"""
MAX_BURN_FRACTION = 2.0
"""Largest burn time in a readout, as a multiple of the motor's: as far off as `MIN_BURN_FRACTION`. [1]"""
MAX_LAUNCH_ANGLE = math.radians(45)
"""A rail is closer to vertical than this: the codes allow 20 and 30 degrees, and beyond 45 a rocket flies farther than
it climbs. [rad]"""
MIN_CALIBER_RATIO, MAX_CALIBER_RATIO = 0.9, 25.0
"""Ratio of a body's diameter to its motor's: a motor fits inside, and saucers are about 15 times as wide. [1]"""


class Burning(Protocol):
    """The motor data that these checks need, as in `fieldkit.motors.Motor`. SI."""

    @property
    def designation(self) -> str: ...
    @property
    def diameter(self) -> float: ...
    @property
    def total_impulse(self) -> float: ...
    @property
    def propellant_mass(self) -> float: ...
    @property
    def casing_mass(self) -> float: ...
    @property
    def peak_thrust(self) -> float: ...
    @property
    def burning(self) -> tuple[float, float]: ...


def implausible(flight: Flight, motor: Burning) -> TextWithAmounts | None:
    """Why no rocket can have flown like this on its motor, as a phrase; None if possible.

    A plan is checked by its setup, a flight also by its readouts. The bounds are physical, with a margin for the
    strongest motor and an altimeter that reads high, so a flight that is merely unusual passes.
    """
    found = (_impossible(flight), _misfit(flight, motor), _too_heavy(flight, motor), _too_far(flight, motor))
    return next((message(reason) for reason in found if reason), None)


def beyond_motor(flight: Flight, motor: Burning) -> dict[str, str]:
    """Boost readouts that no rocket of this mass can reach on its motor, each with the reason.

    A readout counts only if it exceeds the bound by more than two standard deviations. To an altimeter, a burn ends
    when thrust falls below drag plus weight: it may be much shorter than the motor's burn, but not less than half of
    it, and it is never twice as long.
    """
    if flight.dry_mass is None or flight.dry_mass + motor.casing_mass <= 0:
        return {}
    best = f"the most that {motor.designation} gives {_mass(flight.dry_mass)}"
    hardest = MAX_THRUST_RATIO * motor.peak_thrust / (flight.dry_mass + motor.casing_mass)
    bounds = {"top_speed": best_speed(flight.dry_mass, motor), "peak_accel": hardest, "avg_accel": hardest}
    found = {}
    for name, bound in bounds.items():
        value, sd = flight.number(name), flight.sd.get(name, 0.0)
        if value is not None and value - 2 * sd > READ_TOO_HIGH * bound:
            column = BY_NAME[name]
            found[name] = f"{of_column(column, value)} is more than {of_column(column, READ_TOO_HIGH * bound)}, {best}"
    burn, column = flight.number("burn_time"), BY_NAME["burn_time"]
    if burn is not None:
        first, last = motor.burning
        margin, whole = 2 * flight.sd.get("burn_time", 0.0), last - first
        burns = f"{of_column(column, whole)} that {motor.designation} burns"
        if burn + margin < MIN_BURN_FRACTION * whole:
            found["burn_time"] = f"{of_column(column, burn)} is less than half of the {burns}"
        elif burn - margin > MAX_BURN_FRACTION * whole:
            found["burn_time"] = f"{of_column(column, burn)} is more than twice the {burns}"
    return {name: message(reason) for name, reason in found.items()}


def not_measured(flight: Flight, motor: Burning) -> dict[str, str]:
    """Readouts that cannot be measurements, each with the reason. They stay in the ledger but do not enter a fit.

    They are those `beyond_motor`; a peak acceleration below the average one, and the average too if top speed and burn
    time do not confirm it; and, if a device shows a coast of zero, what it counts from burnout or averages up to it: a
    rocket still climbs at burnout, so the device has taken apogee for burnout.
    """
    found = beyond_motor(flight, motor)
    if flight.avg_accel is not None and flight.peak_accel is not None and flight.avg_accel > flight.peak_accel * 1.001:
        why = message(f"average acceleration is above {of_column(BY_NAME['peak_accel'], flight.peak_accel)}, the peak")
        ratio = identity(flight)
        confirmed = ratio is not None and IDENTITY[0] <= ratio <= IDENTITY[1]
        found |= dict.fromkeys(("peak_accel",) if confirmed else ("peak_accel", "avg_accel"), why)
    if flight.coast_to_apogee == 0:
        for name in ("coast_to_apogee", "avg_accel", "apogee_to_eject"):
            if flight.number(name) is not None:
                found.setdefault(name, NO_COAST)
    return found


def best_speed(dry_mass: float, motor: Burning) -> float:
    """Speed that a certified motor, at its strongest, gives a rocket without drag and gravity. [m/s]

    Tsiolkovsky's equation, with the exhaust speed computed from total impulse and propellant mass.
    """
    end = dry_mass + motor.casing_mass
    if motor.propellant_mass <= 0:
        return MAX_THRUST_RATIO * motor.total_impulse / end
    exhaust = motor.total_impulse / motor.propellant_mass
    return MAX_THRUST_RATIO * exhaust * math.log1p(motor.propellant_mass / end)


def best_apogee(dry_mass: float, motor: Burning) -> float:
    """Height reached without drag from `best_speed` at the pad: no burn is better than an instant vertical one. [m]"""
    return float(best_speed(dry_mass, motor) ** 2 / (2 * units.STANDARD_GRAVITY))


def _impossible(flight: Flight) -> str:
    """A phrase for the first value that is not a number or is beyond its limits, which the ledger of an earlier version
    may hold: in `COLUMNS`, in a recovery column that every fit uses, or in the rail direction; empty if there is
    none."""
    for column in COLUMNS:
        value = flight.number(column.name)
        if value is not None and not math.isfinite(value):
            return f"{column.title.lower()}: found {value}, expected a number"
        try:
            if value is not None:
                check(column, value)
        except BadValue as error:
            return f"{column.title.lower()}: {marked(error)}"
    try:
        flight.columns.check(*IN_EVERY_FIT, "rail_direction")
    except BadValue as error:
        return marked(error)
    return ""


def _misfit(flight: Flight, motor: Burning) -> str:
    """A phrase for a body too narrow or too wide for its motor, or a rail closer to horizontal than to vertical."""
    if flight.diameter is not None and not MIN_CALIBER_RATIO <= flight.diameter / motor.diameter <= MAX_CALIBER_RATIO:
        low, high = (ratio * motor.diameter for ratio in (MIN_CALIBER_RATIO, MAX_CALIBER_RATIO))
        beyond = f"more than a diameter of {of_column(BY_NAME['diameter'], high)}, the most"
        if flight.diameter < low:
            beyond = f"less than a diameter of {of_column(BY_NAME['diameter'], low)}, the least"
        return f"a diameter of {of_column(BY_NAME['diameter'], flight.diameter)} is {beyond} around {motor.designation}"
    if flight.rail_angle is not None and abs(flight.rail_angle) > MAX_LAUNCH_ANGLE + 1e-9:
        return f"{_found('rail_angle', flight)} is more than {of_column(BY_NAME['rail_angle'], MAX_LAUNCH_ANGLE)}"
    return ""


def _too_heavy(flight: Flight, motor: Burning) -> str:
    """A phrase for a rocket that its motor cannot lift, even at peak thrust with all propellant gone."""
    if flight.dry_mass is None:
        return ""
    most = MAX_THRUST_RATIO * motor.peak_thrust / units.STANDARD_GRAVITY - motor.casing_mass
    if flight.dry_mass < most:
        return ""
    lifted = of_column(BY_NAME["dry_mass"], most)
    return f"{_mass(flight.dry_mass)} is more than the mass of {lifted} that {motor.designation} lifts"


def _too_far(flight: Flight, motor: Burning) -> str:
    """A phrase for a readout beyond what the motor's impulse allows without drag."""
    if flight.dry_mass is None or flight.dry_mass + motor.casing_mass <= 0:
        return ""
    speed = best_speed(flight.dry_mass, motor)
    bounds = {
        "apogee": best_apogee(flight.dry_mass, motor),
        "top_speed": speed,
        "coast_to_apogee": speed / units.STANDARD_GRAVITY,
    }
    for name, bound in bounds.items():
        value = flight.number(name)
        if value is not None and value > READ_TOO_HIGH * bound:
            most = of_column(BY_NAME[name], READ_TOO_HIGH * bound)
            without_drag = f"{_mass(flight.dry_mass)} on {motor.designation} without drag"
            return f"{_found(name, flight)} is more than {most}, the most for {without_drag}"
    return ""


def _mass(mass: float) -> str:
    """A dry mass [kg] in words, with its amount marked."""
    return f"a dry mass of {of_column(BY_NAME['dry_mass'], mass)}"


def _found(name: str, flight: Flight) -> str:
    """A flight's value in words: `apogee of 281.3 m`."""
    column = BY_NAME[name]
    return f"{column.title.lower()} of {of_column(column, flight.number(name) or 0.0)}"


def identity(flight: Flight) -> float | None:
    """Top speed over average acceleration times burn time, or None if one is missing or zero. [1]"""
    if not (flight.top_speed and flight.avg_accel and flight.burn_time):
        return None
    return flight.top_speed / (flight.avg_accel * flight.burn_time)


def stated_way_down(flight: Flight) -> bool:
    """Whether the descent speed was read off an altimeter, which averages it from ejection to landing, and the coast
    was detected; another device or a log may give the speed of another part."""
    typed = flight.source.get("descent_speed", "typed") == "typed"
    return typed and not flight.has_log and flight.coast_to_apogee != 0


def descent_ratio(flight: Flight) -> float | None:
    """Ejection altitude over descent speed times the time from ejection to landing, infinite if no time is left, or
    None if one of them was not read off the altimeter. [1]"""
    rise = (flight.burn_time, flight.coast_to_apogee, flight.apogee_to_eject)
    if None in rise or not (flight.eject_altitude and flight.descent_speed and flight.duration):
        return None
    if not stated_way_down(flight):
        return None
    sinking = flight.duration - sum(time for time in rise if time is not None)
    return flight.eject_altitude / (flight.descent_speed * sinking) if sinking > 0 else math.inf


def middles(flights: Iterable[Flight]) -> dict[str, float]:
    """Median of each readout over the flights without anomaly tags, except readouts around zero. [SI]"""
    clean = [flight for flight in flights if flight.clean]
    known = {
        c.name: [own for one in clean if (own := one.number(c.name))] for c in READOUTS if c.name not in SIGNED_READOUTS
    }
    return {name: median(values) for name, values in known.items() if values}


def doubts(flight: Flight, usual: Mapping[str, float] = MappingProxyType({})) -> list[TextWithAmounts]:
    """Values in a flight that look mistyped, one phrase each: values outside the range of their column, and readouts
    that contradict each other or the `usual` ones (the `middles` of flights of the same rocket on the same motor)."""
    return [phrase for phrase, _ in doubted(flight, usual)]


def doubted(flight: Flight, usual: Mapping[str, float]) -> Iterator[tuple[TextWithAmounts, tuple[str, ...]]]:
    """The phrases of `doubts`, each with the columns that it concerns."""
    for column in COLUMNS:
        value = flight.number(column.name)
        if value is not None and (phrase := _unusual(column, value)):
            yield phrase, (column.name,)
    ratio, sinking = identity(flight), descent_ratio(flight)
    if ratio is not None and not IDENTITY[0] <= ratio <= IDENTITY[1]:
        yield inconsistent_speed(flight, ratio), ("top_speed", "avg_accel", "burn_time")
    if sinking is not None and not DESCENT[0] <= sinking <= DESCENT[1]:
        yield inconsistent_descent(flight, sinking), ("eject_altitude", "descent_speed", "duration")
    for smaller, larger in (("avg_accel", "peak_accel"), ("eject_altitude", "apogee")):
        low, high = flight.number(smaller), flight.number(larger)
        if low is not None and high is not None and low > high * 1.001:
            small, large = BY_NAME[smaller], BY_NAME[larger]
            yield message(f"{_titled(small, low)} is above {_titled(large, high)}"), (smaller, larger)
    yield from far_from_usual(flight, usual)


def inconsistent_speed(flight: Flight, ratio: float) -> TextWithAmounts:
    """A phrase for a top speed that differs from average acceleration times burn time; `ratio` is
    `identity(flight)` [1].
    """
    off, way = (1 - ratio, "low") if ratio < 1 else (ratio - 1, "high")
    acceleration = of_column(BY_NAME["avg_accel"], flight.avg_accel or 0.0)
    burn = of_column(BY_NAME["burn_time"], flight.burn_time or 0.0)
    return message(f"top speed looks {100 * off:.0f}% {way} for {acceleration} over {burn}; check all three")


def inconsistent_descent(flight: Flight, ratio: float) -> TextWithAmounts:
    """A phrase for a duration that differs from what the ejection altitude takes at the descent speed; `ratio` is
    `descent_ratio(flight)` [1].
    """
    height, speed, duration = (
        of_column(BY_NAME[name], flight.number(name) or 0.0) for name in ("eject_altitude", "descent_speed", "duration")
    )
    way = "long" if ratio < 1 else "short"
    return message(
        f"duration {duration} is too {way} for a descent from {height} at {speed}; check these and the times"
    )


def far_from_usual(flight: Flight, usual: Mapping[str, float]) -> Iterator[tuple[TextWithAmounts, tuple[str, ...]]]:
    """A phrase for each readout that is far from the usual one, with its name."""
    for name, middle in usual.items():
        value = flight.number(name)
        if value and not PLAUSIBLE_RATIO[0] <= value / middle <= PLAUSIBLE_RATIO[1]:
            ratio, usually = value / middle, of_column(BY_NAME[name], middle, digits=3)
            phrase = f"{_titled(BY_NAME[name], value)} is {_times(ratio)} the usual {usually} of this rocket and motor"
            slip = unit_slip(BY_NAME[name], value, math.log(ratio), USUAL_SD) if ratio > 0 else None
            yield message(f"{phrase}; perhaps {slip.words}" if slip else phrase), (name,)


def _times(ratio: float) -> str:
    """A ratio in words: `4.8 times`, `17% of`."""
    if not 1 / MOST_TIMES < abs(ratio) < MOST_TIMES:
        return f"more than {MOST_TIMES} times" if abs(ratio) > 1 else f"less than 1/{MOST_TIMES} of"
    return f"{float(f'{ratio:.2g}'):g} times" if ratio > 1 else f"{float(f'{100 * ratio:.2g}'):g}% of"


def far_from_flown(plan: Flight, flown: Flight) -> Iterator[TextWithAmounts]:
    """A phrase for the dry mass and the diameter of a plan that are far from those of a flight of the same build."""
    for name, (low, high) in BUILD_RATIOS.items():
        value, last, column = plan.number(name), flown.number(name), BY_NAME[name]
        if value and last and not low <= value / last <= high:
            other = "; with another tube it is another configuration" if name == "diameter" else ""
            yield message(f"{_titled(column, value)}, but {of_column(column, last)} in the last flight{other}")


def _unusual(column: Column, value: float) -> TextWithAmounts | None:
    """A phrase for a value outside the plausible range of its column, None for the others."""
    slack = 1e-9 * (1 + abs(value))
    if column.low - slack <= value <= column.high + slack:
        return None
    usual = of_column(column, column.low, column.high)
    return message(f"{_titled(column, value)} is unusual, expected {usual}")


def _titled(column: Column, value: float) -> str:
    return f"{column.title.lower()} {of_column(column, value)}"
