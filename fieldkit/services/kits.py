"""The flyer's kits: listed, saved, deleted, and found by the name of a rocket."""

from collections.abc import Sequence

from fieldkit.file_lock import changing
from fieldkit.paths import data_file
from fieldkit.planning.kit_file import drop_kit, put_kit
from fieldkit.planning.kits import Kit, kit_of, read_kits


def kits() -> Sequence[Kit]:
    """The kits in the order of their file. Raises BadValue for a damaged file."""
    return list(read_kits(data_file("kits.toml")).values())


def kit_of_rocket(rocket: str) -> Kit | None:
    """The kit that a rocket is named after, None if there is none. Raises BadValue for a damaged file."""
    return read_kits(data_file("kits.toml")).get(rocket.casefold())


def named_kit(name: str) -> Kit:
    """The kit with a name. Raises BadValue that suggests the nearest."""
    return kit_of(data_file("kits.toml"), name)


def save_kit(kit: Kit, was: str = "") -> None:
    """Save a kit, or replace the one called `was`. Raises BadValue, FieldkitError if the file cannot be written."""
    with changing(data_file("kits.toml")):
        put_kit(data_file("kits.toml"), kit, was)


def delete_kit(name: str) -> None:
    """Delete a kit. Raises BadValue, FieldkitError if the file cannot be written."""
    with changing(data_file("kits.toml")):
        drop_kit(data_file("kits.toml"), name)
