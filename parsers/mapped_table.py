"""Any table of samples without a parser of its own: a team's own logger, the spreadsheet mailed by AltimeterThree.

The columns are assigned by the flyer's mapping if there is one (`altitude=Alt (ft)`), otherwise by their names. A unit
is taken from the header or the mapping, or inferred from physics; an undetermined unit is an error for time, height and
pressure (see `column_units`), and any other column without a unit is dropped. The assignment is returned as a `Mapped`
for display.

The clock restarts at a second flight in a file; a 16- or 32-bit counter that wraps around does not count as a restart.
A clock that counts from 1970 is shifted to start at the first sample, whose date and time are stored.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing import HEAD, ColumnChoice, Mapped, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.clocks import credible, spread
from fieldkit.importing.tables.column_choice import (
    HEIGHTS,
    SUFFICIENT_CHANNELS,
    Pick,
    chosen,
    guessed,
    missing_channel,
    one_a_channel,
    side_by_side,
    to_si,
)
from fieldkit.importing.tables.column_units import AXES, units_of
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.columns_read import column_read, note_columns
from fieldkit.importing.tables.headings import heading
from fieldkit.importing.tables.layout import Layout, is_even_clock, layout_of
from fieldkit.importing.tables.mapping import choice_for
from fieldkit.importing.tables.pad_state import BOOST_FORCE, ONE_G_RANGE, along_thrust
from fieldkit.importing.tables.text import shown
from fieldkit.importing.tables.unit_inference import epoch_unit, rest
from fieldkit.quantities import counted
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float, Int, Integers
from fieldkit.units import STANDARD_GRAVITY, Unit

SENDER, SENDERS, MOST_SENDERS = "sender", frozenset({"tracker", "callsign", "device", "sender"}), 8
"""The column of words that names who sent a row, the words of its header, and the largest number of senders. [1]"""
COMPUTED = frozenset({"thrust", "drag", "cd", "cp", "cg", "margin", "damping", "reynolds", "angle of attack"})
"""Words of columns that are computed, not measured."""
FREE_FALL = 0.3 * STANDARD_GRAVITY
"""Magnitude below which an accelerometer is in free fall: it feels drag alone. [m/s^2]"""
MIN_FLIGHT_ROWS = 10
"""Smallest number of rows between two jumps of a clock that form a flight, if there is a longer one. [1]"""
LONG_SILENCE, MANY_STEPS, LEAST_CLIMB = 120.0, 500.0, 15.0
"""Shortest gap between two flights of a table [s], in median steps of its clock [1], and the smallest climb [m]."""


def recognises(head: bytes) -> bool:
    layout = layout_of(head)
    named = {pick.channel for pick in guessed(layout)}
    is_log = layout.named or is_even_clock(head, layout, 0)
    return is_log and "time" in named and bool(named & set(SUFFICIENT_CHANNELS))


def read(log: bytes) -> list[Parsed]:
    return read_mapped(log, ())


def read_mapped(log: bytes, choices: Sequence[ColumnChoice]) -> list[Parsed]:
    """The flights of a table by the first matching choice. Raises DamagedLog that explains what to write."""
    layout = layout_of(log[:HEAD])
    if layout.splits_decimals:
        raise DamagedLog(
            f"found {counted(len(layout.first), 'cell')} in a row and fewer names above, expected decimal points, or "
            "semicolons between cells: the commas of the decimals also separate cells",
            row=layout.above + 1,
        )
    choice = choice_for(layout.saved_names, choices)
    first, *others = side_by_side(layout)
    picks = chosen(layout, choice, first) if choice else guessed(layout, first)
    if missing := missing_channel({pick.channel for pick in picks}):
        columns = ", ".join(shown(name) for name in layout.headers[:30])
        raise DamagedLog(
            f"found no column of {missing} among {columns}; name it with --map '{missing}=its column'"
            + ", or how often samples were taken: --map 'time=20 Hz'" * (missing == "time"),
            row=layout.above or None,
        )
    line, found = _one_table(log, layout, picks, choice)
    for columns_of_other in others:
        beside = [pick for pick in guessed(layout, columns_of_other) if pick.place not in {p.place for p in picks}]
        if not missing_channel({pick.channel for pick in beside}):
            more, other = _one_table(log, layout, beside, None)
            line, found = f"{line}; beside it, {more}", _together(found, other)
    kept = ColumnChoice(choice.channels if choice else {}, layout.saved_names)
    mapped = Mapped(line, layout.above or None, kept, chosen=choice is not None and not choice.headers)
    return [mapped, *found]


def _one_table(
    log: bytes, layout: Layout, picks: Sequence[Pick], choice: ColumnChoice | None
) -> tuple[str, list[Parsed]]:
    """The assignment of the columns, in one line, and the flights in them."""
    table = _table(log, layout, picks)
    picks, values = one_a_channel(picks, table)
    table = replace(table, values={})  # a long log is not stored twice
    units, left_out = units_of(picks, values)
    whole = {name: to_si(units[name][0], values[name]) for name in units}
    note_columns([column_read(_column_of(picks, name), name, unit) for name, (_, unit, _) in units.items()])
    readings: list[Parsed] = []
    for name, rows in _by_sender(table) or [("", np.arange(len(table)))]:
        part = replace(table.pick(rows), words={}, found=() if readings else table.found)
        readings += [
            replace(one, serial=name) if isinstance(one, Reading) else one
            for one in _readings(part, {channel: values[rows] for channel, values in whole.items()})
        ]
    if _is_simulated(layout):
        readings = [replace(one, describes="simulation") if isinstance(one, Reading) else one for one in readings]
    return _line(picks, units, left_out, choice), readings


def _is_simulated(layout: Layout) -> bool:
    """Whether a table has columns that only a simulation has: forces, coefficients, centers of a rocket in flight."""
    names = (heading(name) for name in layout.headers)
    return any(set(head.words) & COMPUTED or " ".join(head.words[:3]) in COMPUTED for head in names)


def _by_sender(table: LogTable) -> list[tuple[str, Int[Integers, "row"]]]:
    """The rows of each tracker whose messages one receiver wrote into one table; empty for a table of one."""
    if SENDER not in table.words:
        return []
    known, which = table.words[SENDER]
    rows = [(printable(name), np.flatnonzero(which == place)) for place, name in enumerate(known) if name]
    rows = [(name, those) for name, those in rows if len(those) >= MIN_FLIGHT_ROWS]
    return rows if 1 < len(rows) <= MOST_SENDERS else []


def _together(found: Sequence[Parsed], other: Sequence[Parsed]) -> list[Parsed]:
    """The flights of two side-by-side tables: samples merged flight by flight, or the flights of both separately.

    Tables with the same channels belong to different flights, and clocks that started at different times of day do not
    match.
    """
    flights, more = ([item for item in items if isinstance(item, Reading)] for items in (found, other))
    overlap = any(_channels(one) & _channels(two) for one, two in zip(flights, more, strict=False))
    if overlap or len(flights) != len(more) or any(one.extra for one in flights):
        return [*found, *other]
    beside = iter(more)
    return [
        replace(item, series=item.clocks + next(beside).clocks) if isinstance(item, Reading) else item for item in found
    ]


def _channels(reading: Reading) -> set[str]:
    named = (name for series in reading.clocks for name in series.__slots__ if getattr(series, name) is not None)
    return set(named) - {"time"}


def _table(log: bytes, layout: Layout, picks: Sequence[Pick]) -> LogTable:
    """The selected columns, unconverted, each with its index as its name; without values that no sensor returns."""
    alone = len(side_by_side(layout)) == 1  # of side-by-side tables one ends before the other
    channels = [
        Channel(
            f"{pick.place}",
            pick.place,
            needed=pick.channel == "time" and alone,
            header=pick.name,
            suffix=layout.suffix(pick.place),
            clock=pick.unit == "clock",
        )
        for pick in {pick.place: pick for pick in picks if not pick.counts_rows}.values()
    ]
    senders = (i for i, name in enumerate(layout.headers) if layout.says(i) and set(heading(name).words) & SENDERS)
    place = next(senders, None)
    words = {} if place is None else {SENDER: place}
    return read_columns(
        log, channels, after=layout.above, separator=layout.separator, decimal=layout.decimal, words=words
    )


def _line(
    picks: Sequence[Pick],
    units: Mapping[str, tuple[Unit, str, str]],
    left_out: Mapping[str, str],
    choice: ColumnChoice | None,
) -> str:
    """The mapping as one line of text."""
    parts = []
    for name, (_, unit, why) in units.items():
        column = shown(_column_of(picks, name))
        parts.append(f"{name} = {column} in {printable(unit)}{f' ({why})' if why else ''}")
    source, missing = "guessed from names and units", ""
    if choice:
        source = "as chosen before" if choice.headers else "as chosen"
    elif all(pick.name.startswith("#") for pick in picks):
        source = "without names guessed from their numbers"
    for reason in dict.fromkeys(left_out.values()):
        columns = ", ".join(shown(name) for name, why in left_out.items() if why == reason)
        missing += f"; left out, {reason}: {columns}"
    return f"columns {source}: {', '.join(parts)}{missing}"


_ALIASES = {
    "felt": ("felt?",),
    "acceleration": ("felt?",),
    "altitude_msl": ("altitude",),
    "gps_altitude_msl": ("altitude_msl", "altitude"),
}
"""What a channel was assigned as before it proved to be another."""


def _column_of(picks: Sequence[Pick], channel: str) -> str:
    """The name of the column that a channel was read from."""
    names = {pick.channel: pick.name for pick in picks}
    return next((names[one] for one in (channel, *_ALIASES.get(channel, ())) if one in names), "")


def _readings(table: LogTable, values: Mapping[str, Float[Array, "row"]]) -> list[Parsed]:
    """A reading for every flight of the table, each with a clock that never runs backward."""
    time = values["time"]
    extra = {}
    if epoch_unit(time) == "s":
        start = float(time[np.isfinite(time)][credible(time[np.isfinite(time)])][0])
        begin = datetime.fromtimestamp(start, UTC)
        extra["log_started_utc"] = begin.isoformat(timespec="seconds").replace("+00:00", "Z")
        time = time - start
    if (heights := next((values[name] for name in HEIGHTS if name in values), None)) is not None:
        time = spread(time, np.isfinite(heights))
    table = LogTable({**values, "time": time}, table.rows, found=table.found)
    table = _oldest_first(table.pick(np.isfinite(time)))
    if not len(table):
        raise DamagedLog("found no time in any row, expected numbers")
    parts, found = table.flights()
    parts = [flight for part in parts for flight in _separate_flights(part)]
    longest = max(map(len, parts))
    whole = [part for part in parts if len(part) >= min(MIN_FLIGHT_ROWS, longest)]
    if len(whole) < len(parts):
        found.append(
            Note(
                f"left out {counted(len(parts) - len(whole), 'piece')} of fewer than {MIN_FLIGHT_ROWS} rows, "
                "where the clock jumps"
            )
        )
    readings = [Reading(extra=extra, row=int(part.rows[0]), series=_with_total(part).series()) for part in whole]
    found += [
        Note(f"an acceleration that is never negative has no direction, so {shown(name)} is not used")
        for name in ("felt", "acceleration")
        if name in values and _has_no_sign(values[name])
    ]
    return [*readings, *found]


def _separate_flights(table: LogTable) -> list[LogTable]:
    """The flights of a table whose clock did not restart between them: a long gap in the recording with a climb on both
    sides."""
    time, height = table.values["time"], next((table.values[name] for name in HEIGHTS if name in table.values), None)
    if height is None:
        return [table]
    steps = np.diff(time)
    silent = np.flatnonzero(steps > max(LONG_SILENCE, MANY_STEPS * float(np.median(steps)) if len(steps) else 0.0)) + 1
    bounds = [0, *silent.tolist(), len(time)]
    parts = [slice(first, last) for first, last in pairwise(bounds)]
    climbs = [
        len(known := height[part][np.isfinite(height[part])]) > 0 and np.ptp(known) > LEAST_CLIMB for part in parts
    ]
    return [table.pick(part) for part in parts] if len(parts) > 1 and all(climbs) else [table]


def _oldest_first(table: LogTable) -> LogTable:
    """The table with its rows reversed if its clock runs backward throughout: some lists have the latest row first."""
    steps = np.diff(table.values["time"])
    backward = len(steps) >= MIN_FLIGHT_ROWS and float((steps < 0).mean()) > 0.95
    return table.pick(np.arange(len(table))[::-1]) if backward else table


def _with_total(table: LogTable) -> LogTable:
    """The table with the magnitude of three axes and the acceleration along the rocket, if it lacks these. With fewer
    axes the latter has to be one g on the pad."""
    values = dict(table.values)
    if "felt" in values and _has_no_sign(values["felt"]):
        values.setdefault("felt_total", values.pop("felt"))
    if "acceleration" in values and _has_no_sign(values["acceleration"]):
        del values["acceleration"]
    known = [values[name] for name in AXES if name in values]
    if not known:
        return LogTable(values, table.rows)
    axes = np.stack(known)
    if whole := len(axes) == len(AXES):
        total = np.sqrt((axes**2).sum(axis=0))
        if "felt" in values and _is_total(values["felt"], total):
            values["felt_total"] = values.pop("felt")
        values.setdefault("felt_total", total)
    along = None if {"felt", "acceleration"} & values.keys() else along_thrust(values["time"], axes)
    if along is not None and (
        whole or ONE_G_RANGE[0] < rest(along, values["time"]) / STANDARD_GRAVITY < ONE_G_RANGE[1]
    ):
        values["felt"] = along
    return LogTable(values, table.rows)


def _has_no_sign(felt: Float[Array, "row"]) -> bool:
    """Whether an acceleration of a boost is a magnitude: it is close to zero at times, as in a coast, and never below
    it, although gravity or the drag of a coast slows a rocket down."""
    there = felt[np.isfinite(felt)]
    return there.size > 0 and float(there.max()) > BOOST_FORCE and 0 <= float(there.min()) < FREE_FALL


def _is_total(felt: Float[Array, "row"], total: Float[Array, "row"]) -> bool:
    """Whether a column with no axis in its name is the magnitude of the three axes in the same table."""
    there = np.isfinite(felt) & np.isfinite(total)
    return bool(there.any()) and float(np.quantile(np.abs(felt - total)[there], 0.9)) < 0.05 * STANDARD_GRAVITY


PARSER = Parser("any table of samples, by its columns", recognises, read, fallback=True, mapped=read_mapped)
