"""Units of the selected columns: as the header or the flyer states them, or inferred from physics.

An undetermined unit is an error for time, height and pressure, and for a column that the flyer chose; any other column
is dropped, as are a pressure and a height above sea level beside an altitude in a known unit.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import MOST_FLIGHTS
from fieldkit.importing.tables.clocks import restarts
from fieldkit.importing.tables.column_choice import HEIGHTS, REQUIRED_CHANNELS, Pick, to_si
from fieldkit.importing.tables.headings import QUANTITIES, barometric, heading, unit_named
from fieldkit.importing.tables.text import shown
from fieldkit.importing.tables.unit_inference import (
    InferredUnit,
    clock_units,
    epoch_unit,
    height_of_ratio,
    height_unit_by_pressure,
    height_units_by_free_fall,
    last_of_climb,
    rest,
    settle_felt,
    settle_net,
    settle_pressure,
    settle_time_heights,
)
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY, UNITS, Unit, plain

AXES = ("felt_x", "felt_y", "felt_z")
NO_UNIT, NO_KIND = "no unit", "neither one g nor zero at rest"
"""Why a column is dropped."""
_FELT_COAST, _NET_COAST = (-0.4, 0.2), (-1.4, -0.8)
"""Acceleration felt in the last second of a climb, when drag is small, and net of gravity. [g]"""
_PAD_PRESSURES = (5e4, 1.2e5)
"""Pressures on the ground up to 5,500 m, with a margin for the error of a sensor: less is what a counter of 16 bits
keeps of the usual ones. [Pa]"""
ABOVE_GROUND = 30.0
"""A height that is constant above this before lift-off is not relative to the pad. [m]"""


def units_of(
    picks: Sequence[Pick], values: dict[str, Float[Array, "row"]]
) -> tuple[dict[str, tuple[Unit, str, str]], dict[str, str]]:
    """The unit of every channel, with its name and the reason; and the names of the dropped columns with the reason.

    `values` are updated: `felt?` is renamed to what it proves to be, and a height above another zero to `altitude_msl`.
    Raises DamagedLog for a unit that neither the header nor the values determine.
    """
    by_channel, flown = {pick.channel: pick for pick in picks}, _of_one_flight(values)
    units: dict[str, tuple[Unit, str, str]] = {}
    for name, pick in by_channel.items():
        if pick.unit == "clock":
            units[name] = Unit(1.0), "clock", ""
        elif pick.interval:
            units[name] = Unit(1.0), "s", f"{pick.interval:g} s from row to row, as stated"
        elif pick.unit and (unit := unit_named(QUANTITIES[name.rstrip("?")], pick.unit)):
            units[name] = unit, pick.unit, ""
    if "pressure" in units and not by_channel["pressure"].chosen:
        _check_pressure(by_channel["pressure"], units["pressure"], values, needed="altitude" not in by_channel)
    if height := next((name for name in HEIGHTS if name in units), ""):
        units[height] = _by_physics(by_channel[height], units[height], units, {**flown, "altitude": flown[height]})
    settled = _settled(flown, {name: plain(text) for name, (_, text, _) in units.items()}, units)
    if by_channel.get("time") and by_channel["time"].unit and not epoch_unit(values["time"]):
        settled.pop("time", None)  # a unit that is stated but unknown, as in `time (ticks)`, is not replaced by a guess
    for name, one in settled.items():
        units[name] = unit_named(QUANTITIES[name.rstrip("?")], one.unit) or Unit(1.0), one.unit, one.why
    _settle_net(values, units)
    left_out: dict[str, str] = {}
    for name, pick in by_channel.items():
        spare = name in ("altitude_msl", "pressure") and "altitude" in units
        only = name == "gps_altitude_msl" and not by_channel.keys() & {"altitude", "altitude_msl", "pressure"}
        if name not in units and (pick.chosen or only or (name in REQUIRED_CHANNELS and not spare)):
            expected = ", ".join(list(UNITS[QUANTITIES[name]])[:6])
            found = f"the unit {shown(pick.unit)}" if pick.unit else "no unit, and nothing that implies one"
            usual = _usual(name, values, units)
            raise DamagedLog(
                f"found {found}, expected one of {expected}: write --map '{name}=#{pick.place + 1} [{usual}]'",
                column=printable(pick.name),
            )
        if name not in units:
            left_out[pick.name] = NO_UNIT
    if "felt?" in units and not _settle_kind(values, units, chosen=by_channel["felt?"].chosen):
        left_out[by_channel["felt?"].name] = NO_KIND
    _settle_zero(values, units, by_channel)
    return units, left_out


def _of_one_flight(values: Mapping[str, Float[Array, "row"]]) -> Mapping[str, Float[Array, "row"]]:
    """The values between two restarts of the clock that reach highest: a logger that was switched on twice writes both
    into one table."""
    height = next((name for name in (*HEIGHTS, "pressure") if name in values), "")
    restarted = restarts(values["time"]).tolist()
    if not height or not 0 < len(restarted) < MOST_FLIGHTS:
        return values
    parts = [slice(first, last) for first, last in pairwise([0, *restarted, len(values["time"])])]
    highest = max(parts, key=lambda part: _range(values[height][part]))
    return {name: value[highest] for name, value in values.items()}


def _range(values: Float[Array, "row"]) -> float:
    """The difference of the highest and the lowest value, in their unit; 0 if there is none."""
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0


def _check_pressure(
    pick: Pick, stated: tuple[Unit, str, str], values: dict[str, Float[Array, "row"]], *, needed: bool
) -> None:
    """Raise DamagedLog if the highest pressure is impossible on the ground, and no height could replace it."""
    pressure = values["pressure"][np.isfinite(values["pressure"])]
    highest = float(np.percentile(to_si(stated[0], pressure), 98)) if len(pressure) else 0.0
    other = settle_pressure(pressure)
    if needed and not _PAD_PRESSURES[0] < highest < _PAD_PRESSURES[1]:
        place = pick.place + 1
        hint = f"; write --map 'pressure=#{place} [{other.unit}]', or the unit that you trust" if other else ""
        raise DamagedLog(
            f"found pressures up to {highest / 100:.0f} hPa by the unit {shown(stated[1])}, expected about 1000 hPa"
            + hint,
            column=pick.name,
        )


def _by_physics(
    pick: Pick,
    stated: tuple[Unit, str, str],
    units: Mapping[str, tuple[Unit, str, str]],
    values: Mapping[str, Float[Array, "row"]],
) -> tuple[Unit, str, str]:
    """The stated unit of heights of any zero, the `altitude` of the values, checked against the pressure or, without
    one, against gravity before apogee.

    If physics implies another unit, a note is added if the user chose the stated unit; otherwise DamagedLog is raised.
    """
    unit, name, _ = stated
    by_pressure = height_unit_by_pressure(values)
    shows: tuple[str, ...] = (by_pressure,) if by_pressure else ()
    why = "the pressure column"
    if not by_pressure:
        if "time" not in units:
            return stated
        seconds = {**values, "time": to_si(units["time"][0], values["time"])}
        if height_units_by_free_fall({**seconds, "altitude": to_si(unit, values["altitude"])}, "m") == ("m",):
            return stated
        shows, why = height_units_by_free_fall(seconds, ""), "gravity before apogee"
    if not shows or any(0.7 < unit.factor / UNITS["length"][one].factor < 1.4 for one in shows):
        return stated
    if pick.chosen:
        return unit, name, f"as you chose, although {why} implies {' or '.join(shows)}"
    raise DamagedLog(
        f"found heights in {shown(pick.unit)} that {why} implies to be in {' or '.join(shows)}; "
        f"write --map '{pick.channel}=#{pick.place + 1} [{shows[0]}]', or the unit that you trust",
        column=pick.name,
    )


def _usual(name: str, values: Mapping[str, Float[Array, "row"]], units: Mapping[str, tuple[Unit, str, str]]) -> str:
    """The unit that an error suggests for a channel: the one that its steps or gravity imply, if there is one."""
    fits: tuple[str, ...] = ()
    if name == "time":
        fits = clock_units(values["time"])
    elif name == "altitude" and "time" in units:
        seconds = {**values, "time": to_si(units["time"][0], values["time"])}
        fits = height_units_by_free_fall(seconds, "")
        fits = fits if len(fits) == 1 else ()
    return fits[0] if fits else {"pressure": "Pa"}.get(name, next(iter(UNITS[QUANTITIES[name]])))


def _settled(
    values: Mapping[str, Float[Array, "row"]],
    known: Mapping[str, str],
    units: Mapping[str, tuple[Unit, str, str]],
) -> dict[str, InferredUnit]:
    """Units inferred from physics."""
    si = {name: one for name, one in {"time": "s", "altitude": "m", "speed": "m/s"}.items() if name in units}
    values = {**values, **{name: to_si(units[name][0], values[name]) for name in si}}
    known = {**known, **si}
    height = next((name for name in HEIGHTS if name in values), "")
    by_height, known_by_height = values, known
    if height not in ("altitude", ""):
        of_height = to_si(units[height][0], values[height]) if height in units else values[height]
        by_height, known_by_height = (
            {**values, "altitude": of_height},
            known | ({"altitude": "m"} if height in units else {}),
        )
    elif not height and "pressure" in values:
        by_height = {**values, "altitude": height_of_ratio(values["pressure"])}
        known_by_height = {**known, "altitude": "m"}
    settled = settle_time_heights(by_height, known_by_height)
    if height and "altitude" in settled:
        settled[height] = settled.pop("altitude")
    if "pressure" in values and "pressure" not in units and (one := settle_pressure(values["pressure"])):
        settled["pressure"] = one
    felt = "felt_total" if "felt_total" in values else "felt?"
    if felt in values and felt not in units and (one := settle_felt(values[felt], is_total=felt == "felt_total")):
        settled[felt] = one
    axes = [name for name in AXES if name in values]
    if axes and not any(name in units for name in axes):
        total = np.sqrt(sum((values[name] ** 2 for name in axes), np.zeros_like(values["time"])))
        if one := settle_felt(total, is_total=len(axes) == len(AXES)):
            settled |= dict.fromkeys(axes, one)
    return {name: one for name, one in settled.items() if name not in units}


def _settle_net(values: dict[str, Float[Array, "row"]], units: dict[str, tuple[Unit, str, str]]) -> None:
    """The unit of an acceleration that is zero at rest, by its value before apogee; one that is positive there counts
    downward and is reversed."""
    name = next((name for name in ("felt?", "acceleration") if name in values and name not in units), "")
    height = next((one for one in HEIGHTS if one in units), "")
    if not (name and height and "time" in units):
        return
    time, heights = (to_si(units[one][0], values[one]) for one in ("time", height))
    if one := settle_net(values[name], time, heights):
        units[name] = UNITS["acceleration"][one.unit], one.unit, one.why
        if last_of_climb(time, heights, values[name]) > 0:
            values[name] = -values[name]


def _settle_kind(
    values: dict[str, Float[Array, "row"]], units: dict[str, tuple[Unit, str, str]], *, chosen: bool
) -> bool:
    """Rename an acceleration to what it proves to be, felt or net; False if neither. One of 9.8 g at rest is in another
    unit, unless the user has `chosen` it."""
    unit = units.pop("felt?")
    time = to_si(units["time"][0], values["time"]) if "time" in units else None
    felt = to_si(unit[0], values["felt?"])
    at_rest, why = rest(felt, time) / STANDARD_GRAVITY, "from its value at rest"
    if 0.9 < abs(at_rest) / STANDARD_GRAVITY < 1.1 and not chosen:  # in m/s^2, although its name says g
        unit = UNITS["acceleration"]["m/s2"], "m/s2", why
        felt, at_rest = felt / STANDARD_GRAVITY, at_rest / STANDARD_GRAVITY
    name = "felt" if 0.9 < abs(at_rest) < 1.1 else "acceleration" if abs(at_rest) < 0.1 else ""
    sign = -1 if name == "felt" and at_rest < 0 else 1
    if name != "felt" and time is not None and "altitude" in units:  # it may begin in flight
        coast = last_of_climb(time, to_si(units["altitude"][0], values["altitude"]), felt) / STANDARD_GRAVITY
        sides = {"felt": _FELT_COAST, "acceleration": _NET_COAST}
        by_coast = next((kind for kind, (low, high) in sides.items() if low < coast < high), name)
        name, why = by_coast, why if by_coast == name else "from its value before apogee"
    if not name:
        return False
    if name not in units:
        units[name] = unit[0], unit[1], unit[2] or why
        values[name] = values["felt?"] * sign
    return True


def _settle_zero(
    values: dict[str, Float[Array, "row"]], units: dict[str, tuple[Unit, str, str]], picks: Mapping[str, Pick]
) -> None:
    """Rename heights that do not start at the pad, and those of a tracker, which has a position and no barometer."""
    if "altitude" in units and "altitude_msl" not in units:
        height = to_si(units["altitude"][0], values["altitude"])
        start = height[np.isfinite(height)][:20]
        if len(start) == 20 and float(np.median(start)) > ABOVE_GROUND and float(np.ptp(start)) < 5.0:
            units["altitude_msl"] = *units["altitude"][:2], "it does not start at zero"
            values["altitude_msl"] = values["altitude"]
            del units["altitude"]
    position, others = {"latitude", "longitude"} <= units.keys(), {"felt", "acceleration", "felt_total", *AXES}
    alone = (
        position
        and "gps_altitude_msl" not in units
        and not ({"pressure", "temperature"} & values.keys() or others & units.keys())
    )
    alone = alone and not ("altitude" in units and "speed" in values)  # an altimeter that also states a speed
    own = next((name for name in ("altitude_msl", "altitude") if name in units), None)
    pick = picks.get("altitude", picks.get("altitude_msl"))
    if alone and own and pick and not pick.chosen and not barometric(heading(pick.name)):
        units["gps_altitude_msl"] = *units.pop(own)[:2], "beside a position, and no barometer"
        values["gps_altitude_msl"] = values[own]
