"""Merge several files that one logger wrote of one flight into one reading."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, time, timedelta
from pathlib import Path

from fieldkit.flight.log_origin import LogOrigin, log_origin
from fieldkit.importing.reading import Note, Parsed, Reading

SAME_MOMENT = timedelta(seconds=2)
"""Lift-off times of files of one logger that differ by less than this are of the same flight."""
Opened = tuple[str, str, Sequence[Parsed]]
"""An opened file: its name, its parser, and what the parser found."""


def joined(opened: Sequence[Opened], digests: Sequence[str]) -> list[Opened]:
    """Files in which the parts of each flight are merged into one reading; the other parts' files refer to it.

    The merged reading lists the digests of the other files. A part without others gets a note that more may exist.
    """
    places = [(i, item) for i, (_, _, found) in enumerate(opened) for item in found if isinstance(item, Reading)]
    groups: list[list[tuple[int, Reading]]] = []
    for place in (place for place in places if place[1].part):
        same = [other for group in groups for other in group if _folder(opened, other) == _folder(opened, place)]
        fitting = [group for group in groups if all(_are_parts(place, other, same) for other in group)]
        fitting[0].append(place) if len(fitting) == 1 else groups.append([place])
    found = [list(items) for _, _, items in opened]
    for group in [*groups, *_by_number(opened, places)]:
        (home, main), *others = sorted(group, key=lambda place: _worth(place[1]))
        if not others:
            found[home].append(Note(_PART.format(main.part, main.device), main.row))
            continue
        whole = _whole(main, [other for _, other in others])
        named = tuple(dict.fromkeys(digests[i] for i, _ in others))
        whole = replace(whole, extra={**whole.extra, **LogOrigin(others=named).columns()})
        found[home] = [whole if item is main else item for item in found[home]]
        for i, other in others:
            note = Note(f"belongs to the flight of {opened[home][0]}")
            found[i] = [note if item is other else item for item in found[i]]
    return [(source, format, items) for (source, format, _), items in zip(opened, found, strict=True)]


def _by_number(opened: Sequence[Opened], places: Sequence[tuple[int, Reading]]) -> list[list[tuple[int, Reading]]]:
    """Files of several formats in one folder with the same flight, by flight number and logger serial number."""
    groups: dict[tuple[Path, str, str], list[tuple[int, Reading]]] = {}
    for i, item in places:
        if item.serial and item.clocks and not item.part and (number := log_origin(item.extra).number):
            groups.setdefault((Path(opened[i][0]).parent, item.serial, number), []).append((i, item))
    return [group for group in groups.values() if len({opened[i][1] for i, _ in group}) == len(group) > 1]


_PART = "is the {} file of a flight by {}; import its other files with it or after it to use them"


def _worth(part: Reading) -> int:
    """Rank of a part as the main one, lowest first: one with heights, else one with samples, else any."""
    return 0 if any(series.altitude is not None for series in part.clocks) else 1 if part.clocks else 2


def _folder(opened: Sequence[Opened], place: tuple[int, Reading]) -> tuple[str, Path]:
    """The device of a reading, and the folder of its file."""
    return place[1].device, Path(opened[place[0]][0]).parent


def _are_parts(place: tuple[int, Reading], other: tuple[int, Reading], same: Sequence[tuple[int, Reading]]) -> bool:
    """Whether two readings of files in one folder may belong to one flight.

    `same` are the earlier readings of that folder and device. Without a lift-off time in both, none of them may be of
    the same kind as this one.
    """
    one, two = place[1], other[1]
    if other not in same or place[0] == other[0] or one.part == two.part or len({one.serial, two.serial} - {""}) > 1:
        return False
    first, second = one.stated.get("date_time"), two.stated.get("date_time")
    if not isinstance(first, datetime) or not isinstance(second, datetime):
        return all(one.part != third.part for _, third in same)
    if time() in (first.time(), second.time()):
        return first.date() == second.date()
    return same_moment(first, second)


def same_moment(first: object, second: object) -> bool:
    """Whether two lift-offs in files of one logger are the same: date and time of day, both known."""
    if not isinstance(first, datetime) or not isinstance(second, datetime) or time() in (first.time(), second.time()):
        return False
    return abs(first - second) < SAME_MOMENT


def _whole(main: Reading, others: Sequence[Reading]) -> Reading:
    """Merge several parts into one reading; if they differ, the first one wins."""
    parts = [*reversed(others), main]
    return replace(
        main,
        stated={name: value for part in parts for name, value in part.stated.items()},
        extra={name: value for part in parts for name, value in part.extra.items()},
        events={name: when for part in parts for name, when in part.events.items()},
        series=tuple(series for part in (main, *others) for series in part.clocks),
        device=next((part.device for part in (main, *others) if part.device), ""),
        firmware=next((part.firmware for part in (main, *others) if part.firmware), ""),
        serial=next((part.serial for part in (main, *others) if part.serial), ""),
        part=" ".join(sorted({kind for part in parts for kind in part.part.split()})),
    )
