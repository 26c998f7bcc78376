"""Changes of `kits.toml`; comments and other keys in it are left as they are."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fieldkit.errors import BadValue, unknown
from fieldkit.files import read_own, replace, toml_of
from fieldkit.flight.storable import check_name
from fieldkit.planning.kits import KIT_KEYS, LARGEST_FIGURE, Kit, read_kits

_OWN_LINE = re.compile(rf"\s*(?:{'|'.join(KIT_KEYS)})\s*=")
_NAME = re.compile(r"[A-Za-z0-9_-]+")


def put_kit(file: Path, kit: Kit, was: str = "") -> None:
    """Save a kit, or replace the one called `was`. Raises BadValue for a name that is empty or taken, a figure that is
    not above zero, or a file that cannot be edited line by line."""
    kits = read_kits(file)
    if not kit.name.strip() or not kit.name.isprintable():
        raise BadValue(f"found the name {kit.name!r}, expected a name such as Big Bertha")
    check_name(kit.name)
    if kit.name.casefold() != was.casefold() and kit.name.casefold() in kits:
        raise BadValue(f"found another kit {kits[kit.name.casefold()].name!r}, expected a new name")
    known = zip(KIT_KEYS, kit.figures, strict=True)
    figures = {key: round(value * 1e3, 6) for key, value in known if value is not None}
    for key, value in figures.items():
        if not 0 < value < LARGEST_FIGURE:
            name, _, unit = key.rpartition("_")
            found = f"{name.replace('_', ' ')}: found {value:.0f} {unit}"
            raise BadValue(f"{kit.name}, {found}, expected more than 0 and less than {LARGEST_FIGURE:.0f} {unit}")
    _change(file, was, kit.name, figures)


def drop_kit(file: Path, name: str) -> None:
    """Delete a kit. Raises BadValue if there is none of this name, or if the file cannot be edited line by line."""
    if name.casefold() not in read_kits(file):
        raise BadValue(unknown("kit", name, (kit.name for kit in read_kits(file).values())))
    _change(file, name)


def _change(file: Path, was: str, name: str = "", figures: Mapping[str, float] | None = None) -> None:
    """Replace the heading and the figures of the kit called `was`, or delete it if there are no figures."""
    before = read_own(file) if file.exists() else ""
    text = _edited(before.splitlines(), was, _heading(name), figures)
    try:
        after = toml_of(text)
    except ValueError:
        after = {"": "unreadable"}
    if after != _wanted(toml_of(before), was, name, figures):
        raise BadValue(f"{file}: found kits that are not written as [name] with lines below, expected a change by hand")
    replace(file, text.encode())


def _edited(lines: Sequence[str], was: str, heading: str, figures: Mapping[str, float] | None) -> str:
    """The text of a file in which the lines of a kit are replaced, or deleted if there are no figures."""
    start = next((row for row, line in enumerate(lines) if was and _names(line, was)), len(lines))
    end = next((row for row in range(start + 1, len(lines)) if _heads(lines[row])), len(lines))
    new = [] if figures is None else [heading, *(f"{key} = {value!r}" for key, value in figures.items())]
    rest = [line for line in lines[start + 1 : end] if not _OWN_LINE.match(line)] if new else []
    gap = [""] if new and start == len(lines) and lines and lines[-1].strip() else []
    return "\n".join([*lines[:start], *gap, *new, *rest, *lines[end:]]).strip("\n") + "\n"


def _wanted(tables: Mapping[str, Any], was: str, name: str, figures: Mapping[str, float] | None) -> Mapping[str, Any]:
    """What a file has to contain after a change: everything else in it stays."""
    others = {one: table for one, table in tables.items() if one.casefold() != was.casefold()}
    if figures is None:
        return others
    own: Mapping[str, Any] = next((table for one, table in tables.items() if one.casefold() == was.casefold()), {})
    return {**others, name: {**{key: value for key, value in own.items() if key not in KIT_KEYS}, **figures}}


def _heading(name: str) -> str:
    quoted = '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f"[{name if _NAME.fullmatch(name) else quoted}]"


def _heads(line: str) -> bool:
    return line.lstrip().startswith("[")


def _names(line: str, name: str) -> bool:
    """Whether a line is the heading of a kit."""
    if not _heads(line):
        return False
    try:
        return [one.casefold() for one in toml_of(line)] == [name.casefold()]
    except ValueError:
        return False
