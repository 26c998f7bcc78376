"""How a rocket's flights travel through the code: `python tools/flight_path.py` follows them through one forecast.

`predict` is called with flights to which every effect and several patterns apply. A pass is one function handing the
list of flights to another, as any kind of sequence; each pair of functions counts once, in the order of the first call.
A stop is an unbroken run of passes within one file, so a file that the list returns to is another stop. With
`--holders`, an object that holds the list, such as a model, counts as the list. With `--readings`, what is followed are
the readings of a log and their samples, from their parser to flights. With `--list`, every pass is printed.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from datetime import datetime, timedelta
from itertools import groupby
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

from fieldkit.flight import Flight, Series
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.importing import Reading
from fieldkit.importing.from_samples import with_figures
from fieldkit.importing.recognize import open_log
from fieldkit.motors import catalogue
from fieldkit.physics.effect import effects
from fieldkit.selection.candidates import EACH_GROUP, Pattern, Place

ROOT = Path(__file__).parents[1]
FOLDERS = tuple(f"{ROOT / name}/" for name in ("fieldkit", "parsers", "models"))
FIRST = datetime(2024, 5, 4, 10)
"""Day and hour of the first flight."""
PATTERNS = (Pattern("hour", smooth=True), Pattern("text", "fin", "b"), Pattern("lasting", "6"))
"""Patterns in the flights that a forecast adds."""
MAX_DEPTH = 4
"""Depth to which objects are searched for the flights."""
LOG = ROOT / "sample_logs" / "altos_csv__with_satellites.csv"
"""A log with a barometer, an accelerometer and satellites."""


class Pass(NamedTuple):
    """One function handing the flights to another: files relative to the checkout, and names."""

    source: str
    caller: str
    target: str
    callee: str


def passes(*, holders: bool = False) -> list[Pass]:
    """Every pass of the flights in one forecast, in the order of the first calls."""
    flown = [_flight(number) for number in range(10)]
    motors = catalogue()
    pairs = [(flight, motors.resolve(flight.motor)) for flight in flown]
    planned = [(plan, motors.resolve(plan.motor)) for plan in map(_plan, flown[:3:2])]
    places = [Place(name) for name in effects()] + [Place(pattern=pattern) for pattern in PATTERNS]
    places += [Place(name, EACH_GROUP) for name, effect in effects().items() if effect.each]
    with _followed(lambda value: _carries(value, holders)) as made:
        predict(pairs, planned, Assumed(((1.0, tuple(places)),), cds={"B": 0.6}), draws=20)
    return list(made)


def passes_of_readings() -> list[Pass]:
    """Every pass of the readings of a log, or of their samples, while its readouts are measured."""
    opened = open_log(LOG.read_bytes(), LOG.name, None)
    with _followed(_is_reading) as made:
        with_figures(opened.found, opened.format, "digest")
    return list(made)


@contextmanager
def _followed(carries: Callable[[Any], bool]) -> Iterator[dict[Pass, None]]:
    """The passes of what is followed, in the order of the first calls."""
    made: dict[Pass, None] = {}

    def note(frame: FrameType, event: str, _: object) -> None:
        if event != "call" or not _own(frame.f_code):
            return
        caller = frame.f_back
        while caller and not _own(caller.f_code):
            caller = caller.f_back
        if caller and any(map(carries, _arguments(frame))):
            made.setdefault(Pass(*_named(caller.f_code), *_named(frame.f_code)))

    sys.setprofile(note)
    try:
        yield made
    finally:
        sys.setprofile(None)


def stops(made: list[Pass]) -> list[str]:
    """The files that the flights visit, in order."""
    visited = (file for one in made for file in (one.source, one.target))
    return [file for file, _ in groupby(visited)]


def _plan(flight: Flight) -> Flight:
    return flight.with_changes(flight_id="plan", apogee=None)


def _flight(number: int) -> Flight:
    """A flight with every field that effects and patterns need."""
    return Flight(
        str(number),
        rocket="Astra",
        config="AB"[number % 2],
        motor=("C6-5", "D12-5")[number % 3 == 0],
        dry_mass=0.08,
        apogee=200.0 + 5 * number,
        wind=2.0 + 0.2 * number,
        site="mead",
        temperature=290.0 + number,
        humidity=0.5,
        rail_angle=0.05,
        date_time=FIRST + timedelta(days=number // 5, hours=number % 5),
        extra={"fin": "ab"[number // 3 % 2], "rail_direction": "30", "opening_time": "0.5"},
    )


def _own(code: CodeType) -> bool:
    """Whether this is a function of the engine or a plug-in; a comprehension belongs to the function around it."""
    return code.co_filename.startswith(FOLDERS) and not code.co_name.startswith("<")


def _named(code: CodeType) -> tuple[str, str]:
    return Path(code.co_filename).relative_to(ROOT).as_posix(), code.co_qualname


def _arguments(frame: FrameType) -> Iterator[Any]:
    """The arguments of a call except `self`."""
    code = frame.f_code
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount + bool(code.co_flags & 0x04)]
    return (frame.f_locals[name] for name in names if name != "self" and name in frame.f_locals)


def _is_reading(value: Any) -> bool:
    """Whether a value is a reading, its samples, or a sequence of either."""
    if isinstance(value, list | tuple):
        return bool(value) and _is_reading(value[0])
    return isinstance(value, Reading | Series)


def _carries(value: Any, holders: bool, depth: int = 0) -> bool:
    """Whether a value is a sequence of flown flights, alone or paired with motors, or an object that holds one."""
    if isinstance(value, list | tuple):
        first = value[0] if value else None
        flight = first[0] if isinstance(first, tuple) and first else first
        if isinstance(flight, Flight):
            return flight.apogee is not None
    if not holders or depth == MAX_DEPTH:
        return False
    if isinstance(value, list | tuple):
        return any(_carries(one, holders, depth + 1) for one in value[:3])
    if is_dataclass(value) and not isinstance(value, type):
        return any(_carries(getattr(value, one.name), holders, depth + 1) for one in fields(value))
    return False


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--holders", action="store_true", help="also follow objects that hold the flights")
    parser.add_argument("--readings", action="store_true", help="follow the readings of a log instead")
    parser.add_argument("--list", action="store_true", help="print every pass")
    wanted = parser.parse_args()
    found = passes_of_readings() if wanted.readings else passes(holders=wanted.holders)
    for one in found if wanted.list else ():
        print(f"{one.source}:{one.caller} -> {one.target}:{one.callee}")
    visited = stops(found)
    print(f"{len(found)} passes, {len(visited)} stops in {len(set(visited))} files")
