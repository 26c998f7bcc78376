"""`fieldkit`: its options, its groups of commands, and the one place where errors become a line.

Commands live in modules of this package that bind `app`, and a module is read when one of its commands is named:
nothing heavy is imported before a command runs.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_group

from fieldkit.cli.tui import open_app
from fieldkit.errors import FieldkitError

GROUPS = {
    "tui": ("tui", "serve"),
    "demo": ("demo",),
    "intake": ("import", "export"),
    "capture": ("capture",),
    "add": ("add",),
    "records": ("flights", "show", "edit", "tag", "untag", "remove"),
    "compare": ("compare",),
    "remeasure": ("remeasure",),
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
    "plan": ("delay", "ballast", "contest", "sites"),
    "simulate": ("simulate",),
    "paper": ("paper",),
    "study": ("study",),
    "train": ("train",),
    "docs": ("docs",),
}
"""The commands of every module of `fieldkit.cli`, in the order in which `--help` lists them."""
HOMES = {command: module for module, commands in GROUPS.items() for command in commands}


class OnDemand(Mapping[str, Any]):
    """The commands by name; the module of one is read when it is asked for."""

    def __getitem__(self, command: str) -> Any:
        return _module(HOMES[command])[command]

    def __iter__(self) -> Iterator[str]:
        return iter(HOMES)

    def __len__(self) -> int:
        return len(HOMES)


@cache
def _module(name: str) -> Mapping[str, Any]:
    """The commands of one module."""
    return get_group(import_module(f"fieldkit.cli.{name}").app).commands


class Commands(TyperGroup):
    """All commands of fieldkit, of which a line wakes the one that it names."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings | {"commands": OnDemand()})


app = typer.Typer(
    cls=Commands,
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from fieldkit import __version__
        from fieldkit.shelf import trained_digests

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
            help="Where flights are kept; without it, a file in your data folder.",
        ),
    ] = None,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="Say which fieldkit and which ensembles these are."
        ),
    ] = False,
) -> None:
    """From the altimeter's readouts to the next apogee. Without a command, the app."""
    context.obj = ledger
    if context.invoked_subcommand is None:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            typer.echo(context.get_help())
            raise typer.Exit
        open_app(ledger)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line, that of the process by default, and return its exit status."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that lacks a letter still gets the line
    try:
        app(args=arguments, prog_name="fieldkit")
    except FieldkitError as error:
        from fieldkit.cli.screen import complain

        complain(str(error))
        return 1
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


if __name__ == "__main__":
    sys.exit(main())
