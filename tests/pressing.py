"""The app for tests: opened on a separate ledger at any size, with key presses that wait until the app is idle."""

import asyncio
import atexit
import re
import shutil
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import datetime, timedelta
from functools import cache
from itertools import zip_longest
from pathlib import Path
from tempfile import mkdtemp
from typing import Any
from unittest.mock import patch
from weakref import WeakSet

import pytest
from jaxtyping import config as shapes
from textual._compositor import Compositor
from textual.css.parse import parse
from textual.events import Key
from textual.message import Message
from textual.message_pump import MessagePump
from textual.pilot import Pilot
from textual.widgets import Input, Static

from fieldkit.forecast.at_once import each_at_once
from fieldkit.importing.read import read
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.ledger import Ledger, models
from fieldkit.planning.forecasts import forecasts
from fieldkit.planning.motor_guide import guide
from fieldkit.planning.quick_guide import quick_guide
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.page import PageScreen
from tests.cached import once

ROOT = Path(__file__).parents[1]
FIRST = datetime(2026, 4, 18, 10, 0)
MOMENT = "2026-04-17T18:00:00+00:00"
"""Time stamp of everything in a ledger."""
FULL = {
    "apogee": 281.3,
    "top_speed": 83.4,
    "burn_time": 2.1,
    "peak_accel": 77.5,
    "avg_accel": 39.8,
    "coast_to_apogee": 5.4,
    "apogee_to_eject": -0.4,
    "eject_altitude": 279.9,
    "descent_speed": 6.2,
    "duration": 48.3,
    "site_elevation": 210.0,
    "temperature": 294.8,
    "wind": 2.1,
}
"""Values added to the second reference flight, so that one flight has all readouts. [SI]"""


def season(file: Path) -> None:
    """A ledger of the twelve reference flights with dates and a site; one has every readout, one had a forecast."""
    shutil.copy(_season(), file)


@cache
def _season() -> Path:
    """The ledger that is copied for each test, made once."""
    folder = Path(mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    table = (ROOT / "fieldkit" / "data" / "reference_flights.csv").read_bytes()
    raw = read(table, "reference_flights.csv", lambda name: None).flights
    flights = [
        flight.with_changes(date_time=FIRST + timedelta(minutes=25 * place), site="North field", extra={})
        for place, flight in enumerate(raw)
    ]
    flights[1] = flights[1].with_changes(**FULL)
    apogee = {"mean": 196.0, "sd": 18.0, "p05": 168.0, "p50": 194.0, "p95": 228.0}
    payload = {"rocket": "Astra", "config": "B", "motor": "F39", "model": "field", "apogee_m": apogee}
    with Ledger.open(folder / "ledger.db") as ledger, patch.object(models, "now", lambda: MOMENT):
        ledger.add(flights)
        ledger.keep_prediction(payload, digest="a digest", rocket="Astra", flight_id="12")
    return folder / "ledger.db"


@cache
def looked_at() -> Any:
    """The loop's findings in that season with four possible effects, computed once."""
    from fieldkit.motors import catalogue
    from fieldkit.physics.effect import effects
    from fieldkit.selection import candidates
    from fieldkit.services.close_loop import diagnosis_of
    from fieldkit.services.findings import findings

    some = {name: effects()[name] for name in ("wind", "motor_thrust", "altimeter_scale", "wear")}
    with unchecked(), patch.object(candidates, "effects", lambda: some), Ledger.open(_season()) as ledger:
        return findings("Astra", diagnosis_of(ledger, catalogue(), "Astra"))


def unchecked() -> Any:
    """Shapes are checked in the tests of these functions; here they run four times as fast without checks."""
    return patch.object(shapes, "jaxtyping_disable", True)


STYLES: dict[Any, list[Any]] = {}
"""Parsed style sheets by their inputs, so that each is parsed only once for all tests."""


def parsed(scope: str, css: str, at: Any, variable_tokens: dict[str, list[Any]], **kind: Any) -> list[Any]:
    """The rules of a style sheet, parsed on first use."""
    colors = tuple((name, *(token.value for token in tokens)) for name, tokens in variable_tokens.items())
    asked = (scope, css, at, colors, *kind.items())
    if asked not in STYLES:
        STYLES[asked] = list(parse(scope, css, at, variable_tokens=variable_tokens, **kind))
    return STYLES[asked]


PAINTED = Compositor.render_update
NEXT_MESSAGE = MessagePump._get_message
WAITING: WeakSet[MessagePump] = WeakSet()
"""The app and the widgets that wait for a message. To send each of them a message and wait until it is handled would be
three of four messages in these tests."""
LETTERS = frozenset([*"abcdefghijklmnopqrstuvwxyz0123456789", "full_stop", "minus", "space"])
"""Keys that only add a letter while text is typed."""


def _guided(rocket: Any, plan: Any, motors: Any, *rest: Any) -> object:
    """The cache key for forecasts of many motors."""
    names = [(motor.maker, motor.designation) for motor in motors]
    return repr((rocket.flights, rocket.averaged, rocket.earlier, plan, names, rest))


def _fitted(model: Any, data: Any, *, causes: bool = False) -> object:
    """The cache key for a fit: effects by their names, because functions of plug-ins have no address."""
    terms = [
        (term.name, *[getattr(term, key) for key in ("mean", "sd", "weight", "low", "high", "scaled_by")])
        for term in model.terms
    ]
    past = model.history
    rest = (past.flights, past.found, past.own_area, past.flight_index, repr(model.hyperprior), model.shared)
    return terms, rest, model.coarse, data, causes


ONCE = {
    "fieldkit.planning.motor_guide.guide": once(guide, _guided),
    "fieldkit.planning.quick_guide.quick_guide": once(quick_guide, _guided),
    "fieldkit.services.inferred.each_at_once": once(each_at_once),
    "fieldkit.services.forecasts.forecasts": once(forecasts),
    "fieldkit.forecast.predict.fit_robustly": once(fit_robustly, _fitted),
}
"""Pure functions of the engine that pages call often and that take most of their time."""


def frozen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fixed time zone and time stamp, and cached slow functions."""
    for name, work in ONCE.items():
        monkeypatch.setattr(name, work)
    monkeypatch.setenv("TZ", "UTC")
    if hasattr(time, "tzset"):  # Windows has its own time zone setting
        time.tzset()
    monkeypatch.setattr(models, "now", lambda: MOMENT)


def at_home(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The ledger of that season in a folder, with a user's home beside it."""
    frozen(monkeypatch)
    monkeypatch.setenv("FIELDKIT_HOME", str(folder / "home"))
    season(folder / "ledger.db")
    return folder / "ledger.db"


@asynccontextmanager
async def opened(
    file: Path, size: tuple[int, int] = (80, 24), *, stays: bool = False, page: str = "flights"
) -> AsyncIterator[Pilot[None]]:
    """The app on a ledger with its settings next to it, started on a page and idle; like a flyer's app with `stays`."""
    with (
        unchecked(),
        patch("textual.css.stylesheet.parse", parsed),
        patch.object(FieldkitApp, "DEFAULT_MODE", page),
        patch("textual.app.wait_for_idle", _no_wait),
        patch("textual.pilot.wait_for_idle", _no_wait),
        patch("textual._compositor.Compositor.render_update", _unpainted),
        patch("fieldkit.tui.add.estimate_line.PAUSE", 0.03),  # one estimate for a typed text, not for each letter
        patch("fieldkit.tui.app.EXPIRY", 600.0),  # whatever the load of the machine
    ):
        app = FieldkitApp(file, file.with_name("settings.json"), stays=stays)
        async with app.run_test(size=size) as pilot:
            await calm(pilot)
            yield pilot
            app.workers.cancel_all()
    if app.errors:
        raise app.errors[0]


async def calm(pilot: Pilot[None]) -> None:
    """Wait until all workers are idle, all messages are handled and nothing is deferred to the next paint."""
    quiet = 0
    while quiet < 2:
        await _workers_done(pilot)
        await _all_handled(pilot)
        await pilot.app.animator.wait_until_complete()  # a page that scrolls
        pilot.app.screen._on_timer_update()  # do not wait for the next scheduled paint
        screen = pilot.app.screen
        busy = _busy(pilot)
        due = isinstance(screen, PageScreen) and screen._seen != (pilot.app.revision, pilot.app.look)
        due |= bool(pilot.app._batch_count)  # a new page is hidden until it is laid out
        quiet = 0 if busy or due or screen._callbacks or not _all_read(pilot) else quiet + 1
        if busy or due:
            await asyncio.sleep(0.005)


def _busy(pilot: Pilot[None]) -> bool:
    """Whether a worker is running."""
    return any(not worker.is_finished for worker in pilot.app.workers)


async def _workers_done(pilot: Pilot[None], polls: int = 20) -> None:
    """Wait at most a fifth of a second for the workers, because inspecting all widgets keeps the interpreter from
    them."""
    while polls and _busy(pilot):
        await asyncio.sleep(0.01)
        polls -= 1


async def _all_handled(pilot: Pilot[None], polls: int = 200) -> None:
    """Wait until every message is handled; after some polls with pauses, for a handler that waits itself."""
    for _ in range(
        4
    ):  # a pressed key and the answer of a thread reach the app's queue in two iterations of the event loop
        await asyncio.sleep(0)
    while not _all_read(pilot):
        await asyncio.sleep(0 if polls > 0 else 0.002)
        polls -= 1


def _all_read(pilot: Pilot[None]) -> bool:
    """Whether the app, the front screen and its widgets wait for messages."""
    return all(map(_idle, (pilot.app, *pilot.app.screen.walk_children(with_self=True))))


def _idle(pump: MessagePump) -> bool:
    """Whether a widget waits for its next message and has nothing left to do."""
    if pump._closing or pump._closed:
        return True
    return pump in WAITING and pump._message_queue.empty() and not pump._next_callbacks


async def _waiting(pump: MessagePump) -> Message:
    """Replaces the wait for the next message, to record which widgets are waiting."""
    WAITING.add(pump)
    try:
        return await NEXT_MESSAGE(pump)
    finally:
        WAITING.discard(pump)


MessagePump._get_message = _waiting  # type: ignore[method-assign]  # for every app opened after this


async def press(pilot: Pilot[None], *keys: str) -> None:
    """Press keys one after the other, each when the app is idle again; `_` only waits.

    Letters of one text are sent without waiting in between.
    """
    for key, after in zip_longest(keys or ("_",), keys[1:], fillvalue="_"):
        if key != "_":
            await pilot.app._press_keys([key])
        if not (key in LETTERS and after in LETTERS and isinstance(pilot.app.focused, Input)):
            await calm(pilot)


async def hurry(pilot: Pilot[None], *keys: str) -> None:
    """Press keys as fast as they can be sent, and wait at the end."""
    for key in keys:
        pilot.app.post_message(Key(key, key if len(key) == 1 else None))
    await calm(pilot)


async def _no_wait(*_: float) -> None:
    """Replaces a pause for idling: `calm` detects it without a clock."""


def _unpainted(compositor: Compositor, full: bool = False, **how: Any) -> object:
    """Replaces painting after every change, which takes two fifths of the time of these tests: `shown` paints only what
    is checked."""
    if full:  # a picture
        return PAINTED(compositor, full=True, **how)
    compositor._dirty_regions.clear()
    return None


def typed(text: str) -> list[str]:
    """The keys of a text."""
    names = {" ": "space", "-": "minus", ".": "full_stop", "/": "slash", "=": "equals_sign", ";": "semicolon"}
    names |= {"_": "underscore", "[": "left_square_bracket", "]": "right_square_bracket"}
    return [names.get(letter, letter) for letter in text]


def shown(pilot: Pilot[None]) -> str:
    """The screen as lines of text."""
    screen = pilot.app.screen
    lines = []
    for strip in screen._compositor.render_strips():
        lines.append("".join(segment.text for segment in strip).rstrip())
    return "\n".join(lines)


def text_of(pilot: Pilot[None], place: str) -> str:
    """The text of one widget on one line."""
    return " ".join(str(pilot.app.screen.query_one(place, Static).content).split())


def words(pilot: Pilot[None]) -> str:
    """The screen as one line of words without frames."""
    return re.sub(r"[\s│─╭╮╰╯┌┐└┘█▀▌▁]+", " ", shown(pilot))
