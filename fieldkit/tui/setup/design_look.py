"""A design on the Import page: the start of a rocket, with its text."""

from collections.abc import Mapping
from pathlib import Path

from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME
from fieldkit.openrocket import MAX_UNPACKED_SIZE, Design, read_design
from fieldkit.quantities import measure
from fieldkit.rocket import Configuration
from fieldkit.services.imports import read_file

SUFFIXES = (".ork", ".rkt", ".cdx1")


def design_at(path: Path, given: Mapping[str, str], system: str) -> tuple[Configuration, tuple[str, ...]]:
    """The start of a rocket from a design, with its text.

    Rocket and configuration come from `given`, or else the rocket from the file. Raises FieldkitError if the file
    cannot be read or the rocket is named in neither.
    """
    design = read_design(read_file(path, most=MAX_UNPACKED_SIZE, kind="a design"), path.name)
    name = given.get("rocket") or design.name
    if not name:
        raise BadValue(f"{path.name}: found no name of the rocket, expected one; press e to enter it")
    config = given.get("config", "")
    start = design.start(name, config, path.name)
    return start, (*_facts(start, design, system), *design.notes)


def _facts(start: Configuration, design: Design, system: str) -> list[str]:
    facts = [f"starts {start.rocket} {start.config}".rstrip()]
    if start.dry_mass is not None:
        facts.append(f"{measure(BY_NAME['dry_mass'], start.dry_mass, system)} without motor, from {design.mass_by}")
    if start.diameter is not None:
        facts.append(f"{measure(BY_NAME['diameter'], start.diameter, system)} across")
    if start.margin is not None:
        facts.append(f"stability {start.margin:.1f} calibers with its motor, at small angles")
    facts.append(f"Cd {start.cd:.2f}, from {design.cd_by}" if start.cd else "no Cd in the file")
    return facts
