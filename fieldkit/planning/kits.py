"""The user's kits: mass and diameter of a rocket before its first flight, in `kits.toml` in the user's folder."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from fieldkit.errors import BadValue, unknown
from fieldkit.files import read_toml
from fieldkit.motors.motor import Motor
from fieldkit.planning.toml_values import problem_in

KIT_KEYS = ("dry_mass_g", "diameter_mm", "mount_mm")
"""The figures of a kit in the file."""
LARGEST_FIGURE = 1e6
"""The figures of a kit are below this, in g or mm: a thousand kilograms or meters is a typing error."""
DIAMETER_TOLERANCE = 0.0006
"""Largest difference between two diameters of the same mount. [m]"""


@dataclass(frozen=True, slots=True)
class Kit:
    """A kit as built: dry mass [kg], diameter [m], and the motor mount [m]; None if not known."""

    name: str
    dry_mass: float | None
    diameter: float | None
    mount: float | None

    @property
    def figures(self) -> tuple[float | None, float | None, float | None]:
        """Dry mass [kg], diameter [m] and mount [m], in the order of `KIT_KEYS`."""
        return self.dry_mass, self.diameter, self.mount


def read_kits(file: Path) -> Mapping[str, Kit]:
    """The kits in a file by name, empty if there is no file. Raises BadValue that names the kit and the value."""
    if not file.exists():
        return {}
    try:
        tables = read_toml(file)
    except (ValueError, OSError) as error:
        raise BadValue(f"{file.name}: found {problem_in(error)}, expected TOML") from error
    kits = {}
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise BadValue(
                f"{file.name}: found {name!r} without values, expected [{name}] with dry_mass_g and diameter_mm"
            )
        figures = [_figure(file, name, table, key) for key in KIT_KEYS]
        kits[name.casefold()] = Kit(name, *figures)
    return kits


def kit_of(file: Path, name: str) -> Kit:
    """The kit with a name. Raises BadValue that suggests the nearest."""
    kits = read_kits(file)
    if name.casefold() not in kits:
        where = "" if kits else f"; add it in {file}"
        raise BadValue(unknown("kit", name, (kit.name for kit in kits.values())) + where)
    return kits[name.casefold()]


def check_mount(kit: Kit, motor: Motor) -> None:
    """Raise BadValue for a motor, or one in a cluster, that is wider than the mount of a kit."""
    widest = max(one.diameter for one in motor.parts or (motor,))
    if kit.mount is not None and widest > kit.mount + DIAMETER_TOLERANCE:
        found = f"found {motor.maker} {motor.designation}, {widest * 1e3:g} mm wide"
        raise BadValue(f"--motor: {found}, expected at most {kit.mount * 1e3:g} mm, the motor mount of {kit.name}")


def _figure(file: Path, kit: str, table: Mapping[str, object], key: str) -> float | None:
    value = table.get(key)
    if value is None:
        return None
    if not isinstance(value, int | float) or isinstance(value, bool) or not 0 < value < LARGEST_FIGURE:
        raise BadValue(f"{file.name}, {kit}, {key}: found {value!r}, expected a number above zero")
    return float(value) * 1e-3
