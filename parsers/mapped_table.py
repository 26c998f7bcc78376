"""Any table of samples that no logger's parser knows: a team's own logger, AltimeterThree's mailed sheet.

The columns are taken from the flyer's mapping where there is one (`altitude=Alt (ft)`), else from their names.
A unit is what the header or the mapping says, or what physics settles; one that stays open is an error for time,
height and pressure, and leaves out any other column. What is read as what comes back as a `Mapped`, to be shown.

Two flights in one file start the clock anew; a counter of 16 or 32 bits that runs over does not. A clock that
counts from 1970 starts at the first sample, and the moment of that is kept.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np

from fieldkit.columns import Channel, Table, read_columns
from fieldkit.errors import DamagedLog
from fieldkit.headings import QUANTITIES, channel, heading, plain, stated_unit, unit_named
from fieldkit.layout import Layout, layout_of
from fieldkit.logtext import shown
from fieldkit.mapping import Choice, choice_for
from fieldkit.parsing import HEAD, Found, Mapped, Note, Parser, Reading
from fieldkit.safe_text import printable
from fieldkit.settling import (
    Settled,
    epoch_unit,
    height_unit_by_pressure,
    rest,
    settle_felt,
    settle_pressure,
    settle_time_heights,
)
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY, UNITS, Unit

HEIGHTS = ("altitude", "altitude_msl", "gps_altitude_msl", "inertial_altitude")
ENOUGH = (*HEIGHTS, "pressure", "felt_x", "felt_y", "felt_z", "felt_total", "felt", "felt?", "acceleration")
"""Beside time, one of these makes a table worth reading."""
VITAL = ("time", "altitude", "altitude_msl", "pressure")
"""Channels that are never left out for want of a unit."""
SHORT = 10
"""So many rows between two jumps of a clock are a flight, if there is a longer one. [1]"""
AXES = ("felt_x", "felt_y", "felt_z")
LIMIT = 1e12
"""No sample is this far from zero; what is, was damaged. [any unit but of time]"""
ABOVE_GROUND = 30.0
"""A height that is steady above this before lift-off counts from elsewhere than the pad. [m]"""


@dataclass(frozen=True, slots=True)
class Pick:
    """A column taken for a channel: its place, its name, the unit it or the flyer states ("" if none)."""

    channel: str
    place: int
    name: str
    unit: str
    chosen: bool = False


def recognises(head: bytes) -> bool:
    layout = layout_of(head)
    named = {pick.channel for pick in _guessed(layout)}
    return layout.named and "time" in named and bool(named & set(ENOUGH))


def read(log: bytes) -> list[Found]:
    return read_mapped(log, ())


def read_mapped(log: bytes, choices: Sequence[Choice]) -> list[Found]:
    """The flights of a table by the first choice that is for it; raises DamagedLog that says what to write."""
    layout = layout_of(log[:HEAD])
    choice = choice_for(layout.headers, choices)
    picks = _chosen(layout, choice) if choice else _guessed(layout)
    if missing := _missing({pick.channel for pick in picks}):
        columns = ", ".join(shown(name) for name in layout.headers[:30])
        raise DamagedLog(
            f"found no column of {missing} among {columns}; name it with --map '{missing}=its column'",
            row=layout.above or None,
        )
    table = _table(log, layout, picks)
    picks, values = _one_a_channel(picks, table)
    table = replace(table, values={}, words={})  # a long log is not kept twice
    units, left_out = _units(picks, values)
    whole = {name: _si(units[name][0], values[name]) for name in units}
    line = _line(picks, units, left_out, choice)
    kept = Choice(choice.channels if choice else {}, layout.headers if layout.named else ())
    mapped = Mapped(line, layout.above or None, kept, chosen=choice is not None and not choice.headers)
    return [mapped, *_readings(table, whole)]


def _guessed(layout: Layout) -> list[Pick]:
    """The columns whose names say what they hold."""
    heads = [heading(name) for name in layout.headers]
    picks = []
    for place, head in enumerate(heads):
        name = channel(head)
        if name and not layout.says(place):
            unit = stated_unit(head, "felt" if name == "felt?" else name)
            picks.append(Pick(name, place, head.spelled, _clock_unit(name, unit, layout, place)))
    return _without_clocks_of_others(picks)


def _clock_unit(name: str, unit: str, layout: Layout, place: int) -> str:
    """The unit of a column; a clock written `0:01:02.5` needs none."""
    return "clock" if name == "time" and place < len(layout.first) and ":" in layout.first[place] else unit


def _without_clocks_of_others(picks: list[Pick]) -> list[Pick]:
    """The columns with the first of the clocks only: later ones belong to an update or another sensor."""
    clocks = [pick for pick in picks if pick.channel == "time"]
    return [pick for pick in picks if pick.channel != "time" or pick is clocks[0]]


def _chosen(layout: Layout, choice: Choice) -> list[Pick]:
    """The columns that the flyer named, and what is guessed of the rest. Raises DamagedLog for one not there."""
    picks: list[Pick] = []
    for name, text in choice.channels.items():
        place, unit = _find(layout, text)
        stated = unit or stated_unit(heading(layout.headers[place]), name)
        if stated and QUANTITIES[name] != "degree" and not unit_named(QUANTITIES[name], stated):
            expected = ", ".join(UNITS[QUANTITIES[name]])
            raise DamagedLog(f"found the unit {shown(stated)} for {name}, expected one of {expected}")
        picks.append(Pick(name, place, layout.headers[place], _clock_unit(name, stated, layout, place), chosen=True))
    taken, places = {pick.channel for pick in picks}, {pick.place for pick in picks}
    if "felt" in taken or "acceleration" in taken:
        taken |= {"felt?"}
    return picks + [pick for pick in _guessed(layout) if pick.channel not in taken and pick.place not in places]


def _find(layout: Layout, text: str) -> tuple[int, str]:
    """The place of a column, and the unit that follows its name in brackets. Raises DamagedLog."""
    bare = re.fullmatch(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]", text)
    ways: list[tuple[str, str, Callable[[str], str]]] = [(text, "", _folded)]
    if bare:
        ways.append((bare[1], bare[2], _folded))
    ways.append((text, "", lambda name: " ".join(heading(name).words)))
    for wanted, unit, spelling in ways:
        places = [place for place, name in enumerate(layout.headers) if spelling(name) == _folded(wanted)]
        if wanted.startswith("#") and wanted[1:].isdecimal() and 1 <= int(wanted[1:][:6]) <= len(layout.headers):
            places = [int(wanted[1:][:6]) - 1]
        if len(places) == 1:
            return places[0], unit
        if places:
            numbers = " or ".join(f"#{place + 1}" for place in places)
            raise DamagedLog(f"found {len(places)} columns {shown(wanted)}, expected one; write {numbers} for it")
    columns = ", ".join(shown(name) for name in layout.headers[:30])
    raise DamagedLog(f"found no column {shown(text)}, expected one of {columns}")


def _folded(name: str) -> str:
    return " ".join(name.lower().split())


def _missing(channels: set[str]) -> str:
    if "time" not in channels:
        return "time"
    return "" if channels & set(ENOUGH) else "altitude"


def _table(log: bytes, layout: Layout, picks: Sequence[Pick]) -> Table:
    """The picked columns as they stand, each under its place; without samples that no sensor gives."""
    channels = [
        Channel(f"{pick.place}", pick.place, needed=pick.channel == "time" and pick.unit != "clock", header=pick.name)
        for pick in {pick.place: pick for pick in picks if pick.unit != "clock"}.values()
    ]
    clock = {f"{pick.place}": pick.place for pick in picks if pick.unit == "clock"}
    return read_columns(
        log, channels, after=layout.above, separator=layout.separator, decimal=layout.decimal, words=clock
    )


def _column(pick: Pick, table: Table) -> Float[Array, "row"]:
    """The numbers of a picked column, without those that no sensor gives; a clock's are in seconds."""
    if pick.unit == "clock":
        words, which = table.words[f"{pick.place}"]
        return np.array([_seconds(word) for word in words])[which]
    values = table.values[f"{pick.place}"]
    return _running_on(values) if pick.channel == "time" else np.where(np.abs(values) < LIMIT, values, np.nan)


def _si(unit: Unit, values: Float[Array, "row"]) -> Float[Array, "row"]:
    """Values in a unit as SI values."""
    return values * unit.factor + unit.offset


def _seconds(word: str) -> float:
    """The seconds of `1:02:03.5` or `02:03.5`, after a date or not; nan for anything else. [s]"""
    match = re.fullmatch(r"(?:.*[T ])?(?:(\d{1,3}):)?(\d{1,3}):(\d{1,2}(?:[.,]\d{1,9})?)Z?", word, re.ASCII)
    if not match:
        return float("nan")
    hours, minutes, seconds = match.groups()
    return 3600.0 * int(hours or 0) + 60.0 * int(minutes) + float(seconds.replace(",", "."))


def _one_a_channel(picks: Sequence[Pick], table: Table) -> tuple[list[Pick], dict[str, Float[Array, "row"]]]:
    """One column for each channel. Raises DamagedLog for two that disagree and matter."""
    kept: list[Pick] = []
    values: dict[str, Float[Array, "row"]] = {}
    for pick in picks:
        column = _column(pick, table)
        if np.isnan(column).all():
            continue
        if pick.channel not in values:
            kept.append(pick)
            values[pick.channel] = column
            continue
        rival = next(one for one in kept if one.channel == pick.channel)
        if not _agree(rival, values[pick.channel], pick, column) and pick.channel in VITAL:
            raise DamagedLog(
                f"found two columns for {pick.channel} that differ, {shown(rival.name)} and {shown(pick.name)}; "
                f"choose one with --map '{pick.channel}=its column'"
            )
    if missing := _missing(set(values)):
        raise DamagedLog(f"found no number in the columns of {missing}, expected some")
    return kept, values


def _agree(one: Pick, values: Float[Array, "row"], other: Pick, others: Float[Array, "row"]) -> bool:
    """Whether two columns tell the same in the units they state."""
    units = [unit_named(QUANTITIES[pick.channel.rstrip("?")], pick.unit) for pick in (one, other)]
    if units[0] is None or units[1] is None:
        return False
    apart = np.abs(_si(units[0], values) - _si(units[1], others))
    apart = apart[np.isfinite(apart)]
    reach = np.nanmax(np.abs(_si(units[0], values)), initial=0.0)
    return len(apart) > 0 and float(np.percentile(apart, 90)) <= 0.02 * reach


def _units(
    picks: Sequence[Pick], values: dict[str, Float[Array, "row"]]
) -> tuple[dict[str, tuple[Unit, str, str]], list[str]]:
    """Of every channel its unit, that unit's name and why it is known; and the columns left out.

    `values` follow: `felt?` becomes what it proves to be, a height of elsewhere `altitude_msl`.
    """
    by_channel = {pick.channel: pick for pick in picks}
    units: dict[str, tuple[Unit, str, str]] = {}
    for name, pick in by_channel.items():
        if pick.unit == "clock":
            units[name] = Unit(1.0), "clock", ""
        elif pick.unit and (unit := unit_named(QUANTITIES[name.rstrip("?")], pick.unit)):
            units[name] = unit, pick.unit, ""
    if "altitude" in units and not by_channel["altitude"].chosen:
        _refuse_contradiction(by_channel["altitude"], units["altitude"][0], values)
    settled = _settled(values, {name: plain(text) for name, (_, text, _) in units.items()}, units)
    for name, one in settled.items():
        units[name] = UNITS[QUANTITIES[name.rstrip("?")]][one.unit], one.unit, one.why
    left_out = []
    for name, pick in by_channel.items():
        if name not in units and (name in VITAL or pick.chosen):
            expected = ", ".join(list(UNITS[QUANTITIES[name]])[:6])
            found = f"the unit {shown(pick.unit)}" if pick.unit else "no unit, and nothing that settles it"
            column = pick.name.split("[")[0].split("(")[0].strip() or pick.name
            raise DamagedLog(
                f"found {found}, expected one of {expected}: write --map '{name}={printable(column)} [{_usual(name)}]'",
                column=printable(pick.name),
            )
        if name not in units:
            left_out.append(pick.name)
    _settle_kind(values, units)
    return units, left_out


def _refuse_contradiction(pick: Pick, unit: Unit, values: Mapping[str, Float[Array, "row"]]) -> None:
    """Raise DamagedLog for a height whose stated unit is not the one that the pressure shows."""
    shows = height_unit_by_pressure(values)
    if shows and not 0.7 < unit.factor / UNITS["length"][shows].factor < 1.4:
        raise DamagedLog(
            f"found heights in {shown(pick.unit)} that the pressure beside them shows to be in {shows}; "
            f"write --map 'altitude=#{pick.place + 1} [{shows}]', or the unit that you trust",
            column=pick.name,
        )


def _usual(name: str) -> str:
    return {"time": "s", "pressure": "Pa"}.get(name, next(iter(UNITS[QUANTITIES[name]])))


def _settled(
    values: Mapping[str, Float[Array, "row"]],
    known: Mapping[str, str],
    units: Mapping[str, tuple[Unit, str, str]],
) -> dict[str, Settled]:
    """Units that physics settles."""
    if "time" in units:
        values = {**values, "time": _si(units["time"][0], values["time"])}
        known = {**known, "time": "s"}
    settled = settle_time_heights(values, known)
    if "pressure" in values and "pressure" not in units and (one := settle_pressure(values["pressure"])):
        settled["pressure"] = one
    felt = "felt_total" if "felt_total" in values else "felt?"
    if felt in values and felt not in units and (one := settle_felt(values[felt])):
        settled[felt] = one
    axes = [name for name in AXES if name in values]
    if len(axes) == 3 and not any(name in units for name in axes):
        total = np.sqrt(sum((values[name] ** 2 for name in axes), np.zeros_like(values["time"])))
        if one := settle_felt(total):
            settled |= dict.fromkeys(axes, one)
    return {name: one for name, one in settled.items() if name not in units}


def _settle_kind(values: dict[str, Float[Array, "row"]], units: dict[str, tuple[Unit, str, str]]) -> None:
    """Call a column what it proves to be: felt or net acceleration, height above the pad or above elsewhere."""
    if "felt?" in units:
        unit = units.pop("felt?")
        at_rest = rest(_si(unit[0], values["felt?"])) / STANDARD_GRAVITY
        name = "felt" if 0.9 < abs(at_rest) < 1.1 else "acceleration" if abs(at_rest) < 0.1 else ""
        if name and name not in units:
            units[name] = unit[0], unit[1], unit[2] or "by what it shows at rest"
            values[name] = values["felt?"] * (-1 if name == "felt" and at_rest < 0 else 1)
    if "altitude" in units and "altitude_msl" not in units:
        height = _si(units["altitude"][0], values["altitude"])
        start = height[np.isfinite(height)][:20]
        if len(start) == 20 and float(np.median(start)) > ABOVE_GROUND and float(np.ptp(start)) < 5.0:
            units["altitude_msl"] = *units["altitude"][:2], "it does not start at zero"
            values["altitude_msl"] = values["altitude"]
            del units["altitude"]


def _line(
    picks: Sequence[Pick], units: Mapping[str, tuple[Unit, str, str]], left_out: Sequence[str], choice: Choice | None
) -> str:
    """The mapping in one line."""
    names = {pick.channel: pick.name for pick in picks}
    aliases = {"felt": "felt?", "acceleration": "felt?", "altitude_msl": "altitude"}
    parts = []
    for name, (_, unit, why) in units.items():
        column = names.get(name) or names.get(aliases.get(name, ""), "")
        parts.append(f"{name} = {shown(column)} in {printable(unit)}{f' ({why})' if why else ''}")
    source = "guessed from names and units"
    if choice:
        source = "as chosen before" if choice.headers else "as chosen"
    missing = f"; left out, no unit: {', '.join(map(shown, left_out))}" if left_out else ""
    return f"columns {source}: {', '.join(parts)}{missing}"


def _readings(table: Table, values: Mapping[str, Float[Array, "row"]]) -> list[Found]:
    """A reading for every flight of the table, each with a clock that never runs backwards."""
    time = values["time"]
    extra = {}
    if epoch_unit(time) == "s":
        begin = datetime.fromtimestamp(float(time[0]), UTC)
        extra["log_started_utc"] = begin.isoformat(timespec="seconds").replace("+00:00", "Z")
        time = time - time[0]
    table = Table({**values, "time": time}, table.rows, found=table.found)
    table = table.pick(np.isfinite(time))
    if not len(table):
        raise DamagedLog("found no time in any row, expected numbers")
    parts, found = table.flights()
    longest = max(map(len, parts))
    whole = [part for part in parts if len(part) >= min(SHORT, longest)]
    if len(whole) < len(parts):
        found.append(
            Note(f"left out {len(parts) - len(whole)} pieces of less than {SHORT} rows, where the clock jumps")
        )
    readings = [Reading(extra=extra, row=int(part.rows[0]), series=_with_total(part).series()) for part in whole]
    return [*readings, *found]


def _with_total(table: Table) -> Table:
    """The table with the magnitude of three axes, where it has them and no total of its own."""
    if "felt_total" in table.values or not all(name in table.values for name in AXES):
        return table
    total = np.sqrt(sum((table.values[name] ** 2 for name in AXES), np.zeros(len(table))))
    return Table({**table.values, "felt_total": total}, table.rows)


def _running_on(counter: Float[Array, "row"]) -> Float[Array, "row"]:
    """A counter of 16 or 32 bits that went on counting where it ran over."""
    for span in (2.0**16, 2.0**32):
        over = np.diff(counter, prepend=counter[:1]) < -0.9 * span
        if over.any() and float(np.nanmax(counter)) < span:
            return counter + np.cumsum(over) * span
    return counter


PARSER = Parser("Any table of samples (CSV), by its columns", recognises, read, fallback=True, mapped=read_mapped)
