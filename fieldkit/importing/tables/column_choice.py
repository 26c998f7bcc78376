"""Assign the columns of a table to channels: by their names, or as the flyer specifies."""

import re
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import ColumnChoice, is_exclusion
from fieldkit.importing.tables.columns import LogTable
from fieldkit.importing.tables.headings import (
    CLOCK_UNITS,
    QUANTITIES,
    Heading,
    barometric,
    channel,
    estimated,
    heading,
    is_pressure,
    is_receiver_clock,
    is_sensor_clock,
    is_time_step,
    stated_unit,
    unit_named,
)
from fieldkit.importing.tables.layout import Layout
from fieldkit.importing.tables.missing_marks import without_marks
from fieldkit.importing.tables.positions import falls_in_a_climb, is_elevation, points_down, third_axis
from fieldkit.importing.tables.text import no_column, shown
from fieldkit.importing.tables.unit_inference import settle_pressure
from fieldkit.shapes import Array, Float
from fieldkit.units import UNITS, Unit, plain

HEIGHTS = ("altitude", "altitude_msl", "gps_altitude_msl", "inertial_altitude")
"""Channels that are heights."""
SUFFICIENT_CHANNELS = (
    *HEIGHTS,
    "pressure",
    "felt_x",
    "felt_y",
    "felt_z",
    "felt_total",
    "felt",
    "felt?",
    "acceleration",
)
"""A table is worth reading if it has time and one of these."""
REQUIRED_CHANNELS = ("time", "altitude", "altitude_msl", "pressure")
"""Channels of which two columns that differ, or a missing unit, are an error; of the others a column is dropped.

Beside an altitude in a known unit, a pressure or a height above sea level without a unit is dropped as well.
"""
_START_SAMPLES, _ZERO_PART = 11, 0.01
"""Heights are above the pad if the median of this number of first samples is closer to zero than this fraction of
their range. [1]"""
_LONGEST_INTERVAL = 20.0
"""Time between rows that no log of a flight has. [s]"""
_MUCH = 0.2
"""A sensor that stays constant while another changes by this fraction of its range has failed. [1]"""
_MUCH_FURTHER = 3.0
"""How many times farther than above its start a pressure goes below it in a flight. [1]"""
_CLIPPED_FROM, _LEAST_CLIPPED = 0.995, 4
"""Fraction of its highest value within which an accelerometer is at the end of its range, and number of such rows that
show it. [1]"""
_ALONG = ("felt", "felt?", "acceleration")
"""Channels of an acceleration along the rocket."""
_RISES = 0.9
"""Fraction of rows from which a column of times that is named after steps is a clock all the same. [1]"""
_HOUR = 3600.0
LIMIT = 1e12
"""Largest magnitude of a sample; anything beyond is damaged. [any unit except of time]"""
UNNAMED = ("time", "altitude")
"""What the columns of a table without names are if there are two."""
NO_COLUMN = -1
"""Index of a clock that is the number of each row."""
_COUNTERS = frozenset(
    {"sample", "samples", "index", "row", "record", "n", "nr", "no", "num", "number", "numero", "nummer"}
    | {"packet", "packets", "paket", "paquet", "pkt", "seq", "sequence", "counter", "zeile", "ligne"}
)
"""Words of the names of a column that counts the rows, also those that a radio lost."""
_PARTS_OF_A_TIME = frozenset({"year", "month", "day", "date", "hour", "hours", "h", "hh", "minute", "minutes", "min"})
"""Names of columns with a part of a time of day or a date."""
_RATE = re.compile(r"(\d{1,5}(?:\.\d{1,6})?)\s*Hz", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Pick:
    """A column assigned to a channel: its index, its name, and the unit that it or the flyer states ("" if none)."""

    channel: str
    place: int
    name: str
    unit: str
    chosen: bool = False
    interval: float = 0.0
    """Time between rows if the clock is their number in the file, or in a column that counts them. [s]"""

    @property
    def counts_rows(self) -> bool:
        """Whether it is no column, but the number of each row."""
        return self.place == NO_COLUMN


def side_by_side(layout: Layout) -> list[range]:
    """The columns of each table if several are side by side: each begins with a clock of the same name."""
    heads = [heading(name) for name in layout.headers]
    starts = [i for i, head in enumerate(heads) if channel(head) == "time" and _is_same_clock(head, heads[0])]
    if not starts or starts[0] or any(b - a < 2 for a, b in pairwise(starts)):
        starts = [0]
    return [range(a, b) for a, b in pairwise([*starts, len(heads)])]


def _is_same_clock(one: Heading, other: Heading) -> bool:
    """Whether two names of clocks are one name, or both of a sensor; `T` beside `t` is a temperature."""
    if is_sensor_clock(one) and is_sensor_clock(other):
        return True
    return one.words == other.words and (one.spelled == other.spelled or len(one.words[0]) > 1)


def guessed(layout: Layout, columns: Container[int] | None = None) -> list[Pick]:
    """The columns, or those among `columns`, whose names identify their channel; a clock and a pressure also by their
    contents or unit."""
    if not layout.named:
        return _unnamed(layout)
    heads = [heading(name) for name in layout.headers]
    picks = []
    for place, head in enumerate(heads):
        name = channel(head)
        if name and not layout.says(place) and (columns is None or place in columns):
            unit = stated_unit(head, "felt" if name == "felt?" else name) or layout.suffix(place)
            picks.append(Pick(name, place, head.spelled, _clock_unit(name, unit, layout, place)))
    for of_a_filter in (barometric, estimated):
        if not {pick.channel for pick in picks} & {*HEIGHTS, "pressure"}:
            picks += [
                Pick("altitude", place, head.spelled, stated_unit(head, "altitude") or layout.suffix(place))
                for place, head in enumerate(heads)
                if of_a_filter(head) and not layout.says(place) and (columns is None or place in columns)
            ]
    if not {pick.channel for pick in picks} & {*HEIGHTS, "pressure"}:
        picks += _by_position(layout, {i: head for i, head in enumerate(heads) if columns is None or i in columns})
    picks = _with_axes(picks)
    picks = _without_clocks_of_others(picks + _by_contents(layout, picks, columns))
    if layout.interval and layout.named and "time" not in {pick.channel for pick in picks}:
        picks.append(_row_clock(layout, layout.interval))
    return picks


def _unnamed(layout: Layout) -> list[Pick]:
    """Two columns without names as a clock and heights, whose units physics has to show; more may be anything."""
    if len(layout.headers) != len(UNNAMED):
        return []
    picks = [Pick(name, i, layout.headers[i], layout.suffix(i)) for i, name in enumerate(UNNAMED)]
    return [replace(pick, unit=_clock_unit(pick.channel, pick.unit, layout, pick.place)) for pick in picks]


def _with_axes(picks: Sequence[Pick]) -> list[Pick]:
    """The columns, of which three accelerations that differ only in a number are the axes: `acc[0]`, `acc[1]`, ..."""
    felt = [pick for pick in picks if pick.channel == "felt?"]
    if len(felt) != len("xyz") or not all(_are_numbered(felt[0], other) for other in felt[1:]):
        return list(picks)
    axes = {pick.place: f"felt_{axis}" for pick, axis in zip(felt, "xyz", strict=True)}
    return [replace(pick, channel=axes.get(pick.place, pick.channel)) for pick in picks]


def _by_position(layout: Layout, heads: Mapping[int, Heading]) -> list[Pick]:
    """The height in a table of positions: their third axis, or the elevation beside a latitude."""
    heads = {i: head for i, head in heads.items() if not layout.says(i)}
    name, place = "altitude", third_axis(heads)
    if any(channel(head) == "latitude" for head in heads.values()):
        name, place = "gps_altitude_msl", next((i for i, head in heads.items() if is_elevation(head)), place)
    if place is None:
        return []
    return [Pick(name, place, heads[place].spelled, stated_unit(heads[place], name) or layout.suffix(place))]


def _row_clock(layout: Layout, interval: float) -> Pick:
    """The clock of a table without one, by the time between its rows [s]: a column that counts them, or the number of
    each row in the file."""
    counters = [
        place
        for place, name in enumerate(layout.headers)
        if (words := heading(name).words) and set(words) <= _COUNTERS and not layout.says(place)
    ]
    place = counters[0] if counters else NO_COLUMN
    name = layout.headers[place] if counters else "number of the row"
    return Pick("time", place, name, f"{interval:g} s", interval=interval)


def _by_contents(layout: Layout, picks: Sequence[Pick], columns: Container[int] | None) -> list[Pick]:
    """The clock and the pressure of a table that names neither: times such as `12:04:05.3`, the clock of a satellite
    receiver, and a unit such as hPa."""
    named = {pick.channel for pick in picks}
    free = [i for i in range(len(layout.headers)) if columns is None or i in columns]
    free = [i for i in free if i not in {pick.place for pick in picks} and not layout.says(i)]
    heads = {place: heading(layout.headers[place]) for place in free}
    clocks = [i for i in free if _clock_unit("time", "", layout, i) == "clock"]
    barometers = [i for i in free if is_pressure(heads[i])]
    found = [Pick("time", clocks[0], heads[clocks[0]].spelled, "clock")] if clocks and "time" not in named else []
    if not (found or named & {"time"}) and 0 in heads and heads[0].words in CLOCK_UNITS:
        found = [Pick("time", 0, heads[0].spelled, heads[0].words[0])]
    if not (found or named & {"time"}):
        receivers = [(place, head) for place, head in heads.items() if is_receiver_clock(head)]
        found = [Pick("time", place, head.spelled, stated_unit(head, "time")) for place, head in receivers[:1]]
    if len(barometers) == 1 and not named & {*HEIGHTS, "pressure"}:
        head = heads[barometers[0]]
        found.append(Pick("pressure", barometers[0], head.spelled, stated_unit(head, "pressure")))
    elif not named & {*HEIGHTS, "pressure"}:
        found += _by_letter(layout, heads)
    return found


def _by_letter(layout: Layout, heads: Mapping[int, Heading]) -> list[Pick]:
    """The pressure or the height of a table that names its columns by letters and has no other: `p`, `Pa` or `mb` with
    a pressure that a pad has, otherwise `h` or `z`."""
    letters = {head.words[0]: place for place, head in heads.items() if len(head.words) == 1}
    if place := next((letters[name] for name in ("p", "pa", "mb") if name in letters), None):
        cell = layout.first[place].replace(layout.decimal, ".")
        try:
            pad = np.array([float(cell)])
        except ValueError:
            pad = np.empty(0)
        if settle_pressure(pad) or heads[place].words != ("p",):  # `Pa` is one even if the first value is wrong
            return [Pick("pressure", place, heads[place].spelled, "")]
    return [Pick("altitude", place, heads[place].spelled, "") for name, place in letters.items() if name in ("h", "z")][
        :1
    ]


def _clock_unit(name: str, unit: str, layout: Layout, place: int) -> str:
    """The unit of a column; a clock written `0:01:02.5` needs none."""
    return "clock" if name == "time" and place < len(layout.first) and ":" in layout.first[place] else unit


def _without_clocks_of_others(picks: list[Pick]) -> list[Pick]:
    """The columns with only the first of the clocks; later clocks belong to an update or another sensor. One whose unit
    is unknown, as in `time (not s)`, comes after one whose unit is stated."""
    clocks = [pick for pick in picks if pick.channel == "time"]
    small = {pick.name[:1] for pick in clocks}
    clocks = [
        pick for pick in clocks if not (pick.name[:1] == "T" and "t" in small and len(heading(pick.name).words[0]) == 1)
    ]
    clocks.sort(key=lambda pick: bool(pick.unit) and pick.unit != "clock" and not unit_named("time", pick.unit))
    clocks.sort(key=lambda pick: is_time_step(heading(pick.name)))
    clocks.sort(key=lambda pick: _only_parts_a_time(pick.name))
    return [pick for pick in picks if pick.channel != "time" or pick is clocks[0]]


def _only_parts_a_time(name: str) -> bool:
    """Whether a column has the days, hours or minutes of a time whose seconds are in another column."""
    return set(heading(name).words) <= _PARTS_OF_A_TIME


def chosen(layout: Layout, choice: ColumnChoice, columns: Container[int] | None = None) -> list[Pick]:
    """The columns that the flyer named, and a guess for the rest. Raises DamagedLog for a missing or ambiguous column,
    or a unit that does not fit its channel."""
    picks: list[Pick] = []
    excluded = {_find(layout, text)[0] for name, text in choice.channels.items() if is_exclusion(name)}
    for name, text in choice.channels.items():
        if is_exclusion(name):
            continue
        rate = _RATE.fullmatch(text) if name == "time" and text not in layout.headers else None
        if rate and float(rate[1]) > 0:
            picks.append(replace(_row_clock(layout, 1 / float(rate[1])), chosen=True))
            continue
        place, unit = _find(layout, text)
        if same := next((pick.channel for pick in picks if pick.place == place), ""):
            raise DamagedLog(
                f"found the column {shown(layout.headers[place])} for {same} and {name}, expected two columns"
            )
        stated = unit or stated_unit(heading(layout.headers[place]), name) or layout.suffix(place)
        if stated and QUANTITIES[name] != "degree" and not unit_named(QUANTITIES[name], stated):
            expected = ", ".join(UNITS[QUANTITIES[name]])
            raise DamagedLog(f"found the unit {shown(stated)} for {name}, expected one of {expected}")
        picks.append(Pick(name, place, layout.headers[place], _clock_unit(name, stated, layout, place), chosen=True))
    taken, places = {pick.channel for pick in picks}, {pick.place for pick in picks} | excluded
    if "felt" in taken or "acceleration" in taken:
        taken |= {"felt?"}
    return picks + [pick for pick in guessed(layout, columns) if pick.channel not in taken and pick.place not in places]


def _find(layout: Layout, text: str) -> tuple[int, str]:
    """The index of a column, and the unit that follows its name in brackets. Raises DamagedLog."""
    bare = re.fullmatch(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]", text)
    exact: Callable[[str], str] = str.strip
    ways = [(text, "", exact), *([(bare[1], bare[2], exact)] if bare else []), (text, "", _folded)]
    if bare:
        ways.append((bare[1], bare[2], _folded))
    ways.append((text, "", lambda name: " ".join(heading(name).words)))
    for wanted, unit, spelling in ways:
        sought = wanted.strip() if spelling is exact else _folded(wanted)
        places = [place for place, name in enumerate(layout.headers) if spelling(name) == sought]
        if wanted.startswith("#") and wanted[1:].isdecimal() and 1 <= int(wanted[1:][:6]) <= len(layout.headers):
            places = [int(wanted[1:][:6]) - 1]
        if len(places) == 1:
            return places[0], unit
        if places:
            numbers = " or ".join(f"#{place + 1}" for place in places)
            raise DamagedLog(f"found {len(places)} columns {shown(wanted)}, expected one; write {numbers} for it")
    raise DamagedLog(no_column(text, layout.headers))


def _folded(name: str) -> str:
    return " ".join(name.lower().split())


def missing_channel(channels: set[str]) -> str:
    """The channel that a table of samples lacks; empty if it is complete."""
    if "time" not in channels:
        return "time"
    return "" if channels & set(SUFFICIENT_CHANNELS) else "altitude"


def _column(pick: Pick, table: LogTable) -> Float[Array, "row"]:
    """The numbers of a column, without values that no sensor returns; those of a clock are in seconds."""
    if pick.interval:
        counts = np.asarray(table.rows, float) if pick.counts_rows else table.values[f"{pick.place}"]
        return np.asarray(counts * pick.interval)
    values = table.values[f"{pick.place}"]
    if pick.unit == "clock":
        return _over_midnight(values)
    if pick.channel == "time" and is_time_step(heading(pick.name)) and float((np.diff(values) > 0).mean()) < _RISES:
        return np.nancumsum(values)
    if pick.channel == "time":
        within_minute = len(heading(pick.name).words) == 1 and plain(pick.unit or pick.name) == "s"
        return _running_on(_of_digits(values), (60.0,) if within_minute else ())
    values = without_marks(np.where(np.abs(values) < LIMIT, values, np.nan))
    return _unwrapped(values) if pick.channel in (*HEIGHTS, "pressure") else values


def to_si(unit: Unit, values: Float[Array, "row"]) -> Float[Array, "row"]:
    """Values in a unit as SI values."""
    return values * unit.factor + unit.offset


def one_a_channel(picks: Sequence[Pick], table: LogTable) -> tuple[list[Pick], dict[str, Float[Array, "row"]]]:
    """One column for each channel, and its numbers in its own unit: usually the first that has any.

    Of two heights that differ it is the one that is named after a barometer, otherwise the one that begins at zero,
    because the other is above sea level. Raises DamagedLog for two that disagree and are required, or if a channel that
    the table needs has no number.
    """
    kept: list[Pick] = []
    values: dict[str, Float[Array, "row"]] = {}
    columns = {pick.place: _column(pick, table) for pick in picks}
    for place, pick in enumerate(picks := list(picks)):
        column = columns[pick.place]
        if pick.channel in HEIGHTS and points_down(heading(pick.name), column):
            columns[pick.place] = -column
            picks[place] = replace(pick, name=f"-{pick.name}")
        elif pick.channel == "altitude" and pick.name.startswith("#") and not pick.chosen and falls_first(column):
            picks[place] = replace(pick, channel="pressure")
    picks = _with_satellite_height([pick for pick in picks if not np.isnan(columns[pick.place]).all()], columns)
    picks = _with_wider_range(picks, columns)
    moving = {pick.channel for pick in picks if not _is_stuck(columns[pick.place])}
    for pick in picks:
        column = columns[pick.place]
        others = {pick.channel} if pick.channel not in ("altitude_msl", "pressure") else {pick.channel, "altitude"}
        if not pick.chosen and _is_stuck(column) and others & moving:
            continue
        if pick.channel not in values:
            kept.append(pick)
            values[pick.channel] = column
            continue
        rival = next(one for one in kept if one.channel == pick.channel)
        if _agree(rival, values[pick.channel], pick, column) or pick.channel not in REQUIRED_CHANNELS:
            continue
        if _are_numbered(rival, pick):
            if not rival.chosen and _fails_first(values[pick.channel], column):
                kept[kept.index(rival)], values[pick.channel] = pick, column
                continue
            if rival.chosen or _fails_first(column, values[pick.channel]) or _is_close(values[pick.channel], column):
                continue
        if preferred := _barometric_one(rival, pick):
            kept[kept.index(rival)] = preferred
            values[pick.channel] = column if preferred is pick else values[pick.channel]
            continue
        from_zero = [_starts_at_zero(one) for one in (values[pick.channel], column)]
        beside = pick.channel == "altitude" and _differ_in_zero(rival, values[pick.channel], pick, column)
        if not beside or rival.chosen or all(from_zero) or not any(from_zero):
            raise DamagedLog(
                f"found two columns for {pick.channel} that differ, {shown(rival.name)} and {shown(pick.name)}; "
                f"choose one with --map '{pick.channel}=its column'"
            )
        if from_zero[1]:  # a height above the pad next to one above the sea
            kept[kept.index(rival)], values[pick.channel] = pick, column
    height = next((values[name] for name in HEIGHTS if name in values), None)
    if height is not None and "speed" in values and falls_in_a_climb(values["speed"], height):
        values["speed"] = -values["speed"]
    if missing := missing_channel(set(values)):
        raise DamagedLog(f"found no number in the columns of {missing}, expected at least one")
    return kept, values


def falls_first(values: Float[Array, "row"]) -> bool:
    """Whether values, in any unit, go down in a flight and come back, as pressures do. [Pa]"""
    there = values[np.isfinite(values)]
    if not there.size:
        return False
    start = float(np.median(there[:_START_SAMPLES]))
    return start - float(there.min()) > _MUCH_FURTHER * max(float(there.max()) - start, 0.0)


def _with_wider_range(picks: Sequence[Pick], columns: Mapping[int, Float[Array, "row"]]) -> list[Pick]:
    """The columns without a first accelerometer that is clipped where a second one in the same unit is not: two columns
    along the rocket, or two times three axes."""
    every = [pick for pick in picks if not pick.chosen]
    along = [[pick] for pick in every if pick.channel in _ALONG]
    axes = [[pick for pick in every if pick.channel == f"felt_{axis}"] for axis in "xyz"]
    for kind in (along, [list(one) for one in zip(*axes, strict=False)]):
        for first, second in pairwise(kind):
            if [pick.unit for pick in first] != [pick.unit for pick in second]:
                continue
            highest, wider = (
                max((np.abs(columns[pick.place]) for pick in one), key=np.nanmax) for one in (first, second)
            )
            clipped = int((highest > _CLIPPED_FROM * np.nanmax(highest)).sum()) >= _LEAST_CLIPPED
            if clipped and _beyond(wider, highest):
                picks = [one for one in picks if one not in first]
    return list(picks)


def _beyond(values: Float[Array, "row"], others: Float[Array, "row"]) -> bool:
    """Whether some values exceed all the others clearly."""
    return bool(np.nanmax(values) > (1 + _MUCH) * np.nanmax(others))


def _is_stuck(values: Float[Array, "row"]) -> bool:
    """Whether a sensor returned one value throughout a log."""
    there = values[np.isfinite(values)]
    return there.size >= _START_SAMPLES and float(np.ptp(there)) == 0


def _fails_first(values: Float[Array, "row"], other: Float[Array, "row"]) -> bool:
    """Whether a sensor keeps its last value while another of the same kind still changes by much of its range."""
    there = np.isfinite(values) & np.isfinite(other)
    changes = np.flatnonzero(np.diff(values[there]))
    if not changes.size or not (after := other[there][int(changes[-1]) + 1 :]).size:
        return False
    return float(np.ptp(after)) > _MUCH * float(np.ptp(other[there]))


def _is_close(values: Float[Array, "row"], other: Float[Array, "row"]) -> bool:
    """Whether two sensors of one kind show one flight, as well as sensors of two prices do."""
    there = np.isfinite(values) & np.isfinite(other)
    away = np.abs(values - other)[there]
    return not away.size or float(np.quantile(away, 0.9)) <= _MUCH * float(np.ptp(values[there]))


def _with_satellite_height(picks: Sequence[Pick], columns: Mapping[int, Float[Array, "row"]]) -> list[Pick]:
    """The columns, of which a second height right beside a latitude or longitude is that of the satellites."""
    places = [pick.place for pick in picks if pick.channel in ("latitude", "longitude")]
    heights = [pick for pick in picks if pick.channel in ("altitude", "altitude_msl")]
    has_own = any(pick.channel == "gps_altitude_msl" for pick in picks)
    near = [pick for pick in heights if not pick.chosen and min((abs(pick.place - p) for p in places), default=9) == 1]
    if has_own or len(near) != 1 or len(heights) < 2 or barometric(heading(near[0].name)):
        return list(picks)
    rest = [one for one in heights if one is not near[0] and not _is_stuck(columns[one.place])]
    return [replace(p, channel="gps_altitude_msl") if p is near[0] and rest else p for p in picks]


def _barometric_one(one: Pick, other: Pick) -> Pick | None:
    """The one of two heights that is named after a barometer, if the flyer did not choose the other; None if neither or
    both are."""
    named = [pick for pick in (one, other) if barometric(heading(pick.name))]
    return named[0] if len(named) == 1 and one.channel == "altitude" and not (one.chosen or other.chosen) else None


def _are_numbered(one: Pick, other: Pick) -> bool:
    """Whether two columns are of several sensors of one kind, `alt1` and `alt2`: the first is used."""
    return one.name != other.name and re.sub(r"[\W\d_]", "", one.name) == re.sub(r"[\W\d_]", "", other.name)


def _starts_at_zero(height: Float[Array, "row"]) -> bool:
    """Whether heights, in whatever unit, are relative to the beginning of the log."""
    there = height[np.isfinite(height)]
    return abs(float(np.median(there[:_START_SAMPLES]))) < _ZERO_PART * float(np.ptp(there))


def _differ_in_zero(one: Pick, values: Float[Array, "row"], other: Pick, others: Float[Array, "row"]) -> bool:
    """Whether two columns of one unit, stated or not, differ only in their zero."""
    differences = (others - values)[np.isfinite(others - values)]
    if one.unit != other.unit or not len(differences):
        return False
    away = np.abs(differences - float(np.median(differences)))
    return float(np.percentile(away, 90)) <= 0.02 * float(np.nanmax(values) - np.nanmin(values))


def _agree(one: Pick, values: Float[Array, "row"], other: Pick, others: Float[Array, "row"]) -> bool:
    """Whether two columns agree in the units they state, or without any in their numbers, or one is a copy."""
    if one.unit == other.unit and np.array_equal(values, others, equal_nan=True):
        return True
    units = [unit_named(QUANTITIES[pick.channel.rstrip("?")], pick.unit) for pick in (one, other)]
    if units[0] is not None and units[1] is not None:
        values, others = to_si(units[0], values), to_si(units[1], others)
    elif one.unit != other.unit:
        return False
    differences = np.abs(values - others)
    differences = differences[np.isfinite(differences)]
    reach = np.nanmax(np.abs(values), initial=0.0)
    return len(differences) > 0 and float(np.percentile(differences, 90)) <= 0.02 * reach


def _over_midnight(clock: Float[Array, "row"]) -> Float[Array, "row"]:
    """A time of day continued past midnight, or minutes continued past the hour. [s]"""
    span = _HOUR if float(np.nanmax(clock, initial=0.0)) <= _HOUR else 24 * _HOUR
    over = np.diff(clock, prepend=clock[:1]) < -0.9 * span
    return np.asarray(clock + np.cumsum(over) * span)


def _of_digits(clock: Float[Array, "row"]) -> Float[Array, "row"]:
    """A time of day whose hours, minutes and seconds are digits of one number, `110659.5`, in seconds; other clocks as
    they are.

    No second is above 59, and from one minute to the next it jumps by 40.
    """
    there = np.isfinite(clock)
    minutes, seconds = np.divmod(np.where(there, clock, 0.0), 100.0)
    changes = np.diff(minutes[there]) != 0
    steps = np.diff(clock[there])
    jumps = np.mod(steps[changes], 100.0) - 40.0
    usual = float(np.max(np.abs(steps[~changes]), initial=0.0))
    digits = (seconds < 60).all() and (minutes % 100 < 60).all() and (minutes < 2400).all()
    if not (changes.any() and digits and usual < _LONGEST_INTERVAL and (np.abs(jumps) <= 2 * usual).all()):
        return clock
    return np.asarray(clock - 40 * minutes - 2400 * (minutes // 100))


_WRAPPED_UNITS = (1.0, 0.1, 0.01)
"""Units in which a logger stores a height in 16 bits, relative to the one it is written in: `cm` written in m. [1]"""


def _unwrapped(values: Float[Array, "row"]) -> Float[Array, "row"]:
    """Values stored in 16 bits with their overflows removed: they jump from one end of the range to the other."""
    there = np.flatnonzero(np.isfinite(values))
    known = values[there]
    for unit in _WRAPPED_UNITS if known.size else ():
        span = 2.0**16 * unit
        signed = -span / 2 <= known.min() and known.max() < span / 2
        over = np.abs(np.diff(known)) > 0.9 * span
        if over.any() and (signed or (known.min() >= 0 and known.max() < span)):
            values = values.copy()
            values[there] = np.unwrap(known, period=span)
            break
    return values


def _running_on(counter: Float[Array, "row"], more: Sequence[float] = ()) -> Float[Array, "row"]:
    """A counter of 16 or 32 bits, or of `more` values, with its overflows removed.

    An overflow continues the clock with a step like the others; the restart of a second flight does not.
    """
    steps = np.diff(counter, prepend=counter[:1])
    usual = float(np.nanmax(steps[steps >= 0], initial=0.0))
    for span in (*more, 2.0**16, 2.0**32):
        over = steps < -0.9 * span
        continues = bool((steps[over] + span <= 2 * usual).all())
        if over.any() and continues and float(np.nanmax(counter)) < span:
            return counter + np.cumsum(over) * span
    return counter
