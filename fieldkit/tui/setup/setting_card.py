"""The card of a setting on the Setup page: its meaning, and what it does now."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from textual.content import Content

from fieldkit.errors import LedgerError
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.short_name import short_name
from fieldkit.motors.own import own_motors
from fieldkit.paths import DataFile, data_file, motor_folder
from fieldkit.physics.setups import RAIL_LENGTH
from fieldkit.planning.motor_guide import label
from fieldkit.quantities import ShownUnits, counted, measure
from fieldkit.services.backups import copies
from fieldkit.services.flyer_card import card_texts
from fieldkit.settings import UNITS, BoxedMotors
from fieldkit.tui.next.motor_rows import TARGET_BAND
from fieldkit.tui.resources import Resources
from fieldkit.tui.setup.card_form import QUESTIONS
from fieldkit.tui.setup.setup_card import MAX_DRAWN_FLIGHTS, Facts, apogees_title, draw_apogees
from fieldkit.tui.setup.setup_lists import MEANS
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging
from fieldkit.tui.widgets.plots import Marked, draw_density
from fieldkit.tui.widgets.states import STATES

EXAMPLE = {
    "apogee": 243.84,
    "top_speed": 62.6,
    "dry_mass": 0.322,
    "temperature": 293.15,
    "wind": 3.0,
    "diameter": 0.066,
    "rail_length": 1.83,
    "site_elevation": 210.0,
    "pressure": 101325.0,
    "peak_accel": 98.07,
    "descent_speed": 5.0,
}
"""Figures that show the units. [SI]"""
UNIT_CELLS = 12
"""Width of a figure in a system of units. [cell]"""
LEGEND = (
    ("✓ ◎", "passed, on target"),
    ("! ? ≈", "caution, not given, not final"),
    ("✗ ⊘", "not possible, unsafe"),
    ("◆", "flown"),
)
"""Signs of states and their meaning, those of one color together."""
EXAMPLE_SD = 12.0
"""Standard deviation of the example of a forecast. [m]"""
FILES: Mapping[DataFile, str] = {
    "ledger.db": "your flights, unless another ledger is open",
    "settings.json": "these settings",
    "kits.toml": "your kits",
    "motors": "your .eng and .rse files and corrections of motors",
    "mappings.json": "columns of tables that you named when importing",
    "captures": "what Capture has recorded",
    "measured": "what was read from logs; made again if missing",
    "drafts": "which drafts of flights are open in an app",
    "limits.toml": "your thresholds of the safety checks",
    "rules": "your rule sets beside the shipped ones",
    "seasons": "your contest seasons beside the shipped ones",
    "drills.toml": "your delay drilling tools",
    "hyperprior.json": "how rockets differ, learned from yours",
    "crashes": "reports of errors",
}
"""Every file and folder that fieldkit keeps, and what is in it."""


def of_setting(name: str, resources: Resources, box: tuple[BoxedMotors, ...]) -> Facts:
    """A setting, its meaning, and what it does now. Raises LedgerError."""
    meaning = (cards.lines(name, ()), Hanging(((0, Content(MEANS[name])),)))
    more = _more(name, resources, box)
    return replace(more, blocks=(*meaning, *more.blocks))


def _more(name: str, resources: Resources, box: tuple[BoxedMotors, ...]) -> Facts:
    """What a setting does now, with its picture."""
    settings = resources.settings
    match name:
        case "units":
            return Facts((_units(),))
        case "theme":
            return _theme(settings.units)
        case "target":
            return _target(resources.ledger.latest(), resources)
        case "rail":
            return Facts((cards.lines("Plans start with", _rail(resources)),))
        case "card":
            entered = cards.lines("", list(card_texts(settings, settings.units, box).items()))
            return Facts((entered, cards.lines("What each is for", [(one.title, one.help) for one in QUESTIONS])))
        case "ledger":
            return Facts((cards.lines("Now in it", list(_ledger(resources))),))
        case "your motors":
            return Facts((cards.lines("Now in it", list(_own_motors())),))
        case _:
            return Facts((cards.lines("Files in its folder", list(_files())),))


def _units() -> Hanging:
    """The same figures in every system of units."""
    width = max(len(BY_NAME[name].title) for name in EXAMPLE)
    heading = "".join(f"{one:{UNIT_CELLS}}" for one in UNITS)
    rows = [
        (BY_NAME[name].title, "".join(f"{measure(BY_NAME[name], value, one):{UNIT_CELLS}}" for one in UNITS))
        for name, value in EXAMPLE.items()
    ]
    return cards.lines(f"{'The same figures':{width}}  {heading}", rows, width)


def _theme(system: str) -> Facts:
    """The signs of states in the colors of the theme, and a forecast as it is drawn."""
    lines = (Content.assemble((f"{signs:7}", f"b ${STATES[signs[0]]}"), words) for signs, words in LEGEND)
    draws = EXAMPLE["apogee"] + EXAMPLE_SD * np.random.default_rng(0).standard_normal(2000)
    marks = Marked("◎", EXAMPLE["apogee"] + EXAMPLE_SD), Marked("◆", EXAMPLE["apogee"] - EXAMPLE_SD)
    return Facts(
        (Hanging(tuple((7, line) for line in lines)),),
        "a forecast: filled 90%, line median, ◎ target, ◆ flown",
        draw_density(draws, lambda height: measure(cards.APOGEE, height, system), *marks),
    )


def _target(last: Flight | None, resources: Resources) -> Facts:
    """The flights of the rocket flown last beside the target."""
    target, system = resources.settings.target, resources.settings.units
    if target is None or last is None:
        return Facts(())
    shown, flights = ShownUnits(system), resources.ledger.flights(last.rocket)
    known = [(one.apogee - target, one) for one in flights if one.apogee is not None]
    if not known:
        return Facts(())
    off, nearest = min(known, key=lambda one: abs(one[0]))
    near = sum(abs(miss) <= TARGET_BAND for miss, _ in known)
    pairs = [
        ("within", f"{shown.length(TARGET_BAND)}: {near} of {counted(len(known), 'flight')}"),
        ("nearest", f"flight {short_name(nearest)}, {shown.difference(off)} off"),
    ]
    drawn = [one for _, one in known][-MAX_DRAWN_FLIGHTS:]
    draw = partial(draw_apogees, drawn, target, system) if len(drawn) > 1 else None
    return Facts((cards.lines(f"{last.rocket} so far", pairs),), apogees_title(system) + ", ─ the target", draw)


def _rail(resources: Resources) -> list[tuple[str, str]]:
    """What a plan without a rail of its own starts with, and why."""
    settings, system = resources.settings, resources.settings.units
    length, longest = settings.rail_length, max(settings.flyer.rails, default=None)
    why = (
        "your usual rail"
        if length
        else "the longest that you own"
        if longest
        else "assumed: rockets leave a longer one faster"
    )
    rail = measure(BY_NAME["rail_length"], length or longest or RAIL_LENGTH, system)
    angle = measure(BY_NAME["rail_angle"], settings.rail_angle or 0.0, system)
    owned = ", ".join(measure(BY_NAME["rail_length"], one, system) for one in settings.flyer.rails)
    return [
        ("length", f"{rail}, {why}"),
        ("angle", f"{angle} from vertical"),
        ("you own", owned or "none entered: card"),
    ]


def _ledger(resources: Resources) -> Iterator[tuple[str, str]]:
    """What is in the ledger, how large it is, and its backups."""
    ledger = resources.ledger
    found = ledger.contents()
    yield "flights", f"{found.flights} of {counted(found.rockets, 'rocket')}"
    yield "flown", f"{found.days[0]} to {found.days[1]}" if found.days else ""
    yield "with a log", str(found.with_log)
    yield "changes", f"{ledger.length()} in its journal; u takes back the last"
    try:
        file, kept = copies(resources.where)
    except LedgerError:
        return  # on a server, which has backups of its own
    yield "size", _size(file)
    newest = f", the newest of {kept[0].at.astimezone():%Y-%m-%d %H:%M}" if kept else ""
    yield "backups", f"{len(kept)}{newest}; one is made before the first change of a day"


def _own_motors() -> Iterator[tuple[str, str]]:
    """The motors of the flyer's files, and what cannot be read of them."""
    motors, errors = own_motors(motor_folder())
    for motor in motors:
        yield label(motor), ", ".join((f"{motor.diameter * 1e3:g} mm", f"{motor.total_impulse:.1f} N s", motor.source))
    for error in errors:
        yield "✗", str(error)
    if not motors and not errors:
        yield "none yet", "i in the Motors list adds those of a .eng or .rse file"


def _files() -> Iterator[tuple[str, str]]:
    """The flyer's files and folders: what is in each, and its size."""
    for name, what in FILES.items():
        yield name, f"{what}: {_size(data_file(name))}"


def _size(path: Path) -> str:
    """The size of a file, or the number of files in a folder; `none` if there is neither."""
    try:
        if path.is_dir():
            return counted(sum(1 for _ in path.iterdir()), "file")
        return f"{path.stat().st_size / 1e3:,.1f} kB"
    except OSError:
        return "none"
