"""`fieldkit`: its options, its groups of commands, and the one place where errors become a line.

A group is a module of this package that binds `app`; nothing heavy is imported before a command runs.
"""

import sys
from collections.abc import Sequence
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated

import typer

from fieldkit.cli.tui import open_app
from fieldkit.errors import FieldkitError

GROUPS = (
    "tui",
    "demo",
    "intake",
    "capture",
    "add",
    "records",
    "compare",
    "remeasure",
    "infer",
    "forecast",
    "predictions",
    "loop",
    "score",
    "report",
    "journal",
    "ork",
    "backups",
    "motors",
    "plan",
    "simulate",
    "paper",
    "study",
    "train",
    "docs",
)
"""Modules of `fieldkit.cli` in the order in which `--help` lists their commands."""

app = typer.Typer(
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


for group in GROUPS:
    app.add_typer(import_module(f"fieldkit.cli.{group}").app)


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
