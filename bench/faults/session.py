"""Every command, as called in the session of examples in the manual, and the files it starts from.

The list comes from the command line's own tree: a new command must have an example in `docs/examples.sh`, or a test
fails, so it is also run here.
"""

import asyncio
import shlex
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import chdir, suppress
from dataclasses import dataclass
from datetime import timedelta
from functools import cache
from pathlib import Path
from typing import Any

from textual.worker import WorkerCancelled
from typer.main import get_command

from bench.faults.calls import command
from bench.faults.kills import ADD, CAPTURE, unit
from bench.faults.ledgers import ROOT, fieldkit, season
from fieldkit.cli.main import app
from fieldkit.ledger.backups import STAMP, backups

SESSION = ROOT / "docs" / "examples.sh"
SAMPLES = Path(__file__).with_name("samples")
"""A user's own files that calls refer to, in addition to those of the checkout."""
MORE = (
    "import named.csv --map 'dry_mass=Weighed [g]' --map 'apogee=Reached [ft]'",
    "mappings --edit 1 --map 'apogee=Reached [ft]'",
    "mappings --forget 1",
    "capture PORT --device micropeak --import --set rocket=Comet",
    "predict --flights planned.csv",
    "landing --motor F24-4W --rocket Astra --safety-sheet safety.pdf",
    "daysheet --flights planned.csv --out planned.pdf",
    "weather docs/example-weather.csv --plans planned_at_moor.csv --out filled.csv",
    "loop --rocket Astra --effect motor_thrust",
    "loop --rocket Astra --dry-run --report loop.html",
    "loop --rocket Astra --decline wind",
    "score --rocket Astra --out score.png",
    "motors --import own.eng",
    "motors F24-4W --shortlist-for Astra",
    "motors --fit Astra --target 800ft --class F --shortlist",
    "landing --rocket Astra --motor F24-4W --wind 4m/s --pad 47.5,8.7 --kml landing.kml --card landing.png",
    "ork skylark.ork",
    "import sample_logs/altos_csv__with_satellites.csv",
    "track flight-4f3b53f6c1 --out tracker.kml",
    "learn fieldkit/data/reference_flights.csv --out card.json --keep",
    "paper",
    "study reference --out reference.md",
    "study rockets --out rockets.md",
    "study shortfall --out shortfall.md",
    "backups restore 1 --yes",
    "demo",
)
"""Calls of commands that write only with an option, or of which the session covers another part. `PORT` is a logger."""
FLOWN = "2026-05-02T10:00"
"""Time of flights without one in the session: otherwise the clock's minute would differ between trials."""
FIRST = ("demo",)
"""Commands that require an empty ledger."""
SEPARATE = {"tui": ("tui",), "train": ("train", "--out", "ensemble", "--n-train", "256")}
"""Commands that run in a process of their own only, and how they are called."""
LEFT_OUT = {"serve": "stays open, and writes nothing itself"}
"""Commands that are not run, with the reason."""


@cache
def commands() -> tuple[str, ...]:
    """The names of all commands, from the tree."""
    return tuple(_leaves(get_command(app), ()))


def _leaves(command: Any, path: tuple[str, ...]) -> Iterator[str]:
    if below := getattr(command, "commands", None):
        for name in below:
            yield from _leaves(below[name], (*path, name))
        if not path or not command.invoke_without_command:
            return
    yield " ".join(path)


def files() -> Iterator[tuple[str, str]]:
    """Every command of the tree with an option that takes a file, and that option."""
    for name in commands():
        command = get_command(app)
        for part in name.split():
            command = command.commands[part]  # type: ignore[attr-defined]  # each but the last is a group
        for one in command.params:
            if one.param_type_name == "option" and one.type.name == "path":
                yield name, one.opts[0]


@dataclass(frozen=True, slots=True)
class Call:
    """A command as a user calls it, and the folder it starts from: its ledger and the user's files. `work` runs it; it
    runs from its start in each trial if `separate`."""

    arguments: tuple[str, ...]
    found: Path
    work: Callable[[Path, Sequence[str]], Callable[[], int]] = command
    separate: bool = False

    @property
    def line(self) -> str:
        """The command line."""
        return shlex.join(self.arguments)


def _lines(file: Path) -> list[tuple[str, ...]]:
    lines = (shlex.split(line, comments=True) for line in file.read_text(encoding="utf-8").splitlines())
    return [tuple(words[1:]) for words in lines if words[:1] == ["fieldkit"]]


def lines() -> list[tuple[str, ...]]:
    """The lines of the session."""
    return _lines(SESSION)


def more() -> list[tuple[str, ...]]:
    """The additional calls."""
    return [tuple(shlex.split(line)) for line in MORE]


def calls(folder: Path) -> list[Call]:
    """The lines of the session, each with a copy of the files it starts from, without those that stay open or compute
    for long. The copies are in `folder`. Raises ValueError if a line fails without a fault."""
    workplace, empty = furnished(folder / "workplace"), furnished(folder / "empty")
    made: list[Call] = []
    for number, words in enumerate((*lines(), *more())):
        found, place = folder / "found" / str(number), empty if named(words) in FIRST else workplace
        shutil.copytree(place, found, symlinks=True)
        if named(words) == "add" and "--date-time" not in words:
            words = (*words, "--date-time", FLOWN)
        made.append(Call(words, found))
        with unit(words) as arguments, chdir(place):
            status, _, message = fieldkit(place / "ledger.db", *arguments)
        if status:
            raise ValueError(f"{shlex.join(words)}: {message.strip()}")
    return made


def separate(folder: Path, name: str) -> list[Call]:
    """The call of a command of `SEPARATE`, in a ledger with a flight whose tag can be undone."""
    found = furnished(folder)
    season(found / "ledger.db")
    fieldkit(found / "ledger.db", "tag", "1", "mine")
    return [Call(SEPARATE[name], found, undoing_app if name == "tui" else command, separate=True)]


def undoing_app(file: Path, _: Sequence[str]) -> Callable[[], int]:
    """The app, in which a key undoes the latest change: it prints its notices, and its exit status is 0 if they say
    that it was done."""

    async def pressing() -> int:
        from fieldkit.tui.app import FieldkitApp

        app = FieldkitApp(file, file.with_name("settings.json"))
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.press("u")
            with suppress(WorkerCancelled):  # a page that is shown again reads the ledger again
                await app.workers.wait_for_complete()
            await pilot.pause()
            notices = [one.text for one in app.notices]
        sys.stderr.write("\n".join(notices))
        return not any(one.startswith("Undone") for one in notices)

    return lambda: asyncio.run(pressing())


def new_day(folder: Path) -> list[Call]:
    """`add` and `capture --import`, in a ledger whose only backup is a day old, so that both make another."""
    found = furnished(folder)
    ledger = found / "ledger.db"
    season(ledger)
    fieldkit(ledger, "tag", "1", "mine")
    for one in backups(ledger):
        earlier = one.at - timedelta(days=1)
        one.file.rename(one.file.with_name(f"{one.number:06d}_{earlier:{STAMP}}_{one.changes}.db"))
    return [Call(ADD, found), Call(CAPTURE, found)]


def furnished(workplace: Path) -> Path:
    """A folder in which the session's paths are links to files of the checkout."""
    workplace.mkdir(parents=True)
    for name in ("sample_logs", "fieldkit", "docs"):
        (workplace / name).symlink_to(ROOT / name)
    for file in sorted(SAMPLES.iterdir()):
        shutil.copy(file, workplace)
    return workplace


def named(arguments: Sequence[str]) -> str:
    """The command that a line calls, by its name in the tree."""
    known = set(commands())
    return next((name for count in (2, 1) if (name := " ".join(arguments[:count])) in known), arguments[0])
