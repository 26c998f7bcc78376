"""`fieldkit`: its options, its groups of commands, and the one place that turns errors into a line of text.

Commands live in modules of this package that bind `app`. A module is imported only when one of its commands is used, so
nothing heavy is imported before a command runs.
"""

import gc
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from inspect import cleandoc
from io import TextIOWrapper
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup
from typer.main import get_group

from fieldkit.cli.bare_numbers import note_bare_options
from fieldkit.cli.metavars import name_values, refuse_empty_paths
from fieldkit.cli.screen import complain, system
from fieldkit.cli.tui import open_app
from fieldkit.cli.units import ask_units_once, in_terminal
from fieldkit.errors import LEAST_BEGINNING, MAX_NEAREST, FieldkitError
from fieldkit.plugins import trained_digests
from fieldkit.quantities import in_system

GROUPS = {
    "tui": ("tui", "serve"),
    "demo": ("demo",),
    "importing": ("inspect", "import", "export"),
    "mappings": ("mappings",),
    "capture": ("capture",),
    "add": ("add",),
    "records": ("flights", "show", "edit", "tag", "untag", "remove"),
    "compare": ("compare",),
    "remeasure": ("remeasure",),
    "weather": ("weather",),
    "infer": ("infer",),
    "forecast": ("predict",),
    "predictions": ("predictions",),
    "loop": ("loop", "model"),
    "score": ("score",),
    "report": ("report",),
    "journal": ("undo", "redo", "history"),
    "ork": ("ork",),
    "backups": ("backups",),
    "motors": ("motors",),
    "plan": ("delay", "ballast"),
    "contest": ("contest", "finals"),
    "season": ("season",),
    "landing": ("landing", "track"),
    "daysheet": ("daysheet",),
    "units": ("units",),
    "sites": ("sites",),
    "kits": ("kits",),
    "flyer": ("flyer",),
    "simulate": ("simulate",),
    "paper": ("paper",),
    "study": ("study",),
    "learn": ("learn",),
    "train": ("train",),
    "docs": ("docs",),
}
"""The commands of every module of `fieldkit.cli`."""
SUBJECTS = {
    "Flights": (
        *("inspect", "import", "export", "mappings", "capture", "add", "flights", "show", "edit"),
        *("tag", "untag", "remove", "compare", "remeasure", "weather"),
    ),
    "Forecasts and the loop": ("infer", "predict", "predictions", "loop", "model", "score", "report"),
    "Motors": ("motors", "delay", "ballast", "simulate"),
    "A day, a field and a season": (
        *("landing", "track", "daysheet", "contest", "finals", "season", "ork", "sites", "kits", "flyer"),
    ),
    "The ledger and the program": ("tui", "serve", "demo", "undo", "redo", "history", "backups", "units", "docs"),
    "Studies": ("paper", "study", "learn", "train"),
}
"""The commands by subject, in the order of `--help` and of the manual."""
SUBJECT_OF = {command: subject for subject, commands in SUBJECTS.items() for command in commands}
"""The subject of each command."""
PAGES = {
    "app": ("tui", "serve"),
    "formats": ("inspect", "import"),
    "spreadsheet": ("export", "mappings"),
    "after-flight": ("add", "show", "edit", "tag", "untag", "score", "report"),
    "weather": ("weather",),
    "predictions": ("infer", "predict", "predictions"),
    "loop": ("loop", "model"),
    "first-rocket": ("ork", "kits"),
    "planning": ("motors", "delay", "ballast", "daysheet", "flyer", "simulate"),
    "landing": ("landing", "track"),
    "safety": ("sites",),
    "contest": ("contest", "finals", "season"),
    "other-programs": ("compare",),
    "troubleshooting": ("capture", "undo", "redo", "history", "backups"),
    "reference-study": ("paper", "study"),
    "priors": ("learn",),
    "models": ("train",),
}
"""The commands that a page of the manual explains; their help names it."""
EXPLAINED_ON = {command: page for page, commands in PAGES.items() for command in commands}
"""The page of the manual of each command that has one."""
HOMES = {command: module for module, commands in GROUPS.items() for command in commands}
"""The module of each command."""

OTHER_WORDS = {
    "backup": "backups",
    "delete": "remove",
    "forecast": "predict",
    "help": "--help",
    "list": "flights",
    "log": "add",
    "merge": "edit",
    "new": "add",
    "rename": "edit",
    "rockets": "flights",
    "settings": "units",
    "version": "--version",
}
"""What flyers type for a command that has another name."""
OTHER_OPTIONS = {"--altitude": "--apogee", "--height": "--apogee", "--weight": "--dry-mass", "--speed": "--top-speed"}
"""What flyers type for an option that has another name."""
WITHOUT_UNITS = ("units", "docs")
"""Commands that are answered before the units are chosen."""
WITHOUT_QUESTIONS = frozenset({"--json", "--help", "-h"})
"""Options whose answer is for a program, or the same in all units."""


UsageError: Any = typer.BadParameter.__mro__[1]
"""What is raised for a wrong command line, such as an option that does not exist."""


class OnDemand(Mapping[str, Any]):
    """The commands by name; a command's module is imported once, when it is first needed."""

    def __init__(self) -> None:
        self._read = cache(_module)

    def __getitem__(self, command: str) -> Any:
        return self._read(HOMES[command])[command]

    def __iter__(self) -> Iterator[str]:
        return iter(SUBJECT_OF)

    def __len__(self) -> int:
        return len(HOMES)


def _module(name: str) -> Mapping[str, Any]:
    """The commands of one module."""
    commands: Mapping[str, Any] = get_group(import_module(f"fieldkit.cli.{name}").app).commands
    for title, command in commands.items():
        name_values(command)
        refuse_empty_paths(command)
        _join_lines(command)
        command.rich_help_panel = SUBJECT_OF.get(title)
        if title in EXPLAINED_ON:
            command.epilog = f"In the manual: fieldkit docs {EXPLAINED_ON[title]}"
    return commands


def _join_lines(command: Any) -> None:
    """Join the lines of each paragraph of the help, so that it wraps at the width of the terminal alone."""
    paragraphs = cleandoc(command.help or "").split("\n\n")
    command.help = "\n\n".join(" ".join(lines.split()) for lines in paragraphs)
    for inner in getattr(command, "commands", {}).values():
        _join_lines(inner)


class Commands(TyperGroup):
    """All commands of fieldkit; only the module of the requested one is imported."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings | {"commands": OnDemand()})

    def resolve_command(self, context: Any, arguments: list[str]) -> tuple[str | None, Any, list[str]]:
        """The command that the arguments name, before which the units are asked for at the first start."""
        if meant := OTHER_WORDS.get(arguments[0]):
            context.fail(f"No such command {arguments[0]!r}. Did you mean {meant!r}?")
        found = super().resolve_command(context, arguments)
        if found[0] not in WITHOUT_UNITS and WITHOUT_QUESTIONS.isdisjoint(arguments):
            ask_units_once()
        note_bare_options(found[1], found[2])
        return found

    def invoke(self, context: Any) -> Any:
        """Run the command; for an option that it does not have, those that begin with it or contain it come first."""
        try:
            return super().invoke(context)
        except UsageError as error:
            if (typed := getattr(error, "option_name", "")) and error.ctx:
                error.possibilities = _meant(typed, error.ctx.command) or error.possibilities
            raise


def _meant(typed: str, command: Any) -> list[str]:
    """The options of a command that an unknown one begins, or whose words contain it, or that have another name."""
    dashed = {f"--{(one.name or '').replace('_', '-')}" for one in command.params}
    known = {opt for one in command.params for opt in one.opts} & dashed
    starting = [one for one in sorted(known) if len(typed) > LEAST_BEGINNING and one.startswith(typed)]
    within = [one for one in sorted(known) if f"-{typed.lstrip('-')}-" in f"{one}-"]
    return list(dict.fromkeys(one for one in (OTHER_OPTIONS.get(typed), *starting, *within) if one in known))[
        :MAX_NEAREST
    ]


app = typer.Typer(
    cls=Commands,
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from fieldkit import __version__

        typer.echo(f"fieldkit {__version__}")
        for name, digest in trained_digests().items():
            typer.echo(f"ensemble {name} sha256:{digest}")
        raise typer.Exit


@app.callback()
def options(
    context: typer.Context,
    ledger: Annotated[
        str | None,
        typer.Option(
            envvar="FIELDKIT_LEDGER",
            metavar="PATH_OR_URL",
            help="The ledger that holds your flights; default: a file in your data folder.",
        ),
    ] = None,
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_version,
            is_eager=True,
            help="Show the version of fieldkit and the digests of its ensembles.",
        ),
    ] = False,
) -> None:
    """Forecast your rocket's next apogee from its altimeter readouts. Without a command, open the app."""
    context.obj = ledger
    if context.invoked_subcommand is None:
        if not in_terminal():
            typer.echo(context.get_help())
            raise typer.Exit
        ask_units_once()
        open_app(ledger)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line, by default that of the process, and return its exit status."""
    os.environ["MPLBACKEND"] = "agg"  # pictures go to files, and a backend that is not installed is an error
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # print the line even if the terminal lacks a character
    try:
        status = _status(arguments)
        with suppress(BrokenPipeError):  # the command has finished; only its reader is gone
            sys.stdout.flush()
        return status
    except FieldkitError as error:
        found = in_system(error, system())
    except BrokenPipeError:
        return 1  # the reader of the pipe has closed it
    except MemoryError:
        found = "found too little memory for this many flights or configurations, expected fewer in the ledger"
    except OSError as error:
        found = f"{error.filename or 'the output'}: found {error.strerror}, expected a file that can be read or written"
        if not error.filename:
            found += "; the command may have finished, check `fieldkit history`"
    complain(found)
    return 1


def _open_streams() -> None:
    """Open the standard streams that the parent process has closed, as by `>&-`, so that no file opened later gets one
    of their numbers: the input is empty, results cannot be written, messages are dropped."""
    for name, mode, access in (("stdin", "r", os.O_RDONLY), ("stdout", "w", os.O_RDONLY), ("stderr", "w", os.O_WRONLY)):
        if getattr(sys, name) is None:  # Python's stand-in for a closed stream
            setattr(sys, name, os.fdopen(os.open(os.devnull, access), mode, encoding="utf-8", closefd=False))


def _status(arguments: Sequence[str] | None) -> int:
    try:
        app(args=arguments, prog_name="fieldkit")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def run() -> NoReturn:
    """Run the command line of the process, and exit.

    Without `gc.freeze` the interpreter searches everything for garbage before it ends: `flights` takes 0.37 s of
    processor time instead of 0.31 s, `predict` 1.16 s instead of 0.97 s. The matrices of a rocket are small: threads of
    OpenBLAS, which reads its variable when numpy is imported, only wait for each other. On two cores `loop` on six logs
    takes 14 s of processor time instead of 33 s. Imports of modules make a hundred thousand lasting objects: with the
    usual threshold they are searched for garbage 200 times, which takes 0.04 s of the 1.04 s of an import of one log.
    """
    gc.set_threshold(50_000)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    status = main()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # its reader is gone, and the interpreter would complain that it cannot flush it either
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    gc.freeze()
    sys.exit(status)


if __name__ == "__main__":
    run()
