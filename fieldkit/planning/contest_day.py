"""The day of a contest: announcements, declared flights and goals, in addition to the rules of its season."""

from dataclasses import dataclass

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.planning.contest import Season


@dataclass(frozen=True, slots=True)
class Day:
    """Data of a contest day: `target` [m] and `window` [s] as announced, the points to qualify (`cut`), the flights
    `declared` so far, and the `length` of the rocket [m]; None or empty if not known."""

    target: float | None = None
    window: tuple[float, float] | None = None
    cut: float | None = None
    declared: tuple[str, ...] = ()
    length: float | None = None

    def rule(self, season: Season) -> Season:
        """The rules of a season with the announced values."""
        return season.announced(self.target, self.window)


def read_window(text: str) -> tuple[float, float]:
    """Parse the announced window of durations, typed as `37-40`. Raises BadValue. [s]"""
    return _range(text, "seconds, the lower first, such as 37-40", " s")


def read_targets(text: str) -> tuple[float, float]:
    """Parse the lowest and the highest target that may be announced, typed as `775-825`. Raises BadValue. [ft]"""
    return _range(text, "feet, the lower first, such as 775-825", " ft")


def _range(text: str, expected: str, unit: str) -> tuple[float, float]:
    """Two numbers with a dash between them. Raises BadValue. [their unit]"""
    wanted = BadValue(f"found {text[:40]!r}, expected {expected}")
    try:
        low, high = (float(part.strip(unit)) for part in text.split("-"))
    except ValueError:
        raise wanted from None
    if not 0 <= low < high < 1e4:
        raise wanted
    return low, high


def read_declared(text: str) -> tuple[str, ...]:
    """Parse the declared flights, typed as `4,5,6`."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def read_points(text: str) -> float:
    """Parse points. [1] Raises BadValue if the text is not a number."""
    try:
        points = float(text)
    except ValueError:
        points = float("nan")
    if not 0 <= points < 1e6:
        raise BadValue(f"found {text!r}, expected points such as 60")
    return points


def read_part(name: str, text: str, unit: str) -> object:
    """Parse one entry of a day, or a length of its site; None if the text is empty. Raises BadValue."""
    if name == "declared":
        return read_declared(text)
    if not text.strip():
        return None
    if name == "window":
        return read_window(text)
    if name == "cut":
        return read_points(text)
    length = units.parse(text, "length", unit)
    if not 0 < length < 1e5:
        raise BadValue(f"found {text!r}, expected a length above zero, such as 800ft")
    return length
