"""Changes of `kits.toml`; comments and other keys in it are left as they are."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from fieldkit.errors import BadValue
from fieldkit.files import read_own, replace, toml_of
from fieldkit.planning.kits import KIT_KEYS, LARGEST_FIGURE, Kit, read_kits

_OWN_LINE = re.compile(rf"\s*(?:{'|'.join(KIT_KEYS)})\s*=")
_NAME = re.compile(r"[A-Za-z0-9_-]+")


def put_kit(file: Path, kit: Kit, was: str = "") -> None:
    """Save a kit, or replace the one called `was`. Raises BadValue for a name that is empty or taken, a figure that is
    not above zero, or a file that cannot be edited line by line."""
    kits = read_kits(file)
    if not kit.name.strip() or not kit.name.isprintable():
        raise BadValue(f"found the name {kit.name!r}, expected a name such as Big Bertha")
    if kit.name.casefold() != was.casefold() and kit.name.casefold() in kits:
        raise BadValue(f"found another kit {kits[kit.name.casefold()].name!r}, expected a new name")
    known = zip(KIT_KEYS, kit.figures, strict=True)
    figures = {key: round(value * 1e3, 6) for key, value in known if value is not None}
    for key, value in figures.items():
        if not 0 < value < LARGEST_FIGURE:
            raise BadValue(f"{kit.name}, {key}: found {value:g}, expected a number above zero")
    lines = [f"{key} = {value!r}" for key, value in figures.items()]
    _change(file, was, [_heading(kit.name), *lines], {**kits, kit.name.casefold(): kit})


def drop_kit(file: Path, name: str) -> None:
    """Delete a kit. Raises BadValue if there is none of this name, or if the file cannot be edited line by line."""
    kits = dict(read_kits(file))
    if kits.pop(name.casefold(), None) is None:
        raise BadValue(f"found no kit {name!r} in {file.name}")
    _change(file, name, [], kits)


def _change(file: Path, was: str, new: Sequence[str], wanted: Mapping[str, Kit]) -> None:
    """Replace the heading and the figures of a kit; `wanted` are the kits that the file has to hold then."""
    lines = read_own(file).splitlines() if file.exists() else []
    start = next((row for row, line in enumerate(lines) if was and _names(line, was)), len(lines))
    end = next((row for row in range(start + 1, len(lines)) if _heads(lines[row])), len(lines))
    rest = [line for line in lines[start + 1 : end] if not _OWN_LINE.match(line)] if new else []
    gap = [""] if new and start == len(lines) and lines and lines[-1].strip() else []
    text = "\n".join([*lines[:start], *gap, *new, *rest, *lines[end:]]).strip("\n") + "\n"
    try:
        tables = toml_of(text)
    except ValueError:
        tables = {}
    if {name.casefold() for name in tables} != {one.casefold() for one in _without(wanted, was, new)}:
        raise BadValue(f"{file}: found kits that are not written as [name] with lines below, expected a change by hand")
    replace(file, text.encode())


def _without(wanted: Mapping[str, Kit], was: str, new: Sequence[str]) -> set[str]:
    """The names of the wanted kits, without the former name of a renamed one."""
    renamed = bool(new) and was and new[0] != _heading(was) and not _names(new[0], was)
    return {name for name in wanted if not (renamed and name == was.casefold())}


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
