"""`fieldkit tui`, and `fieldkit` alone: the app."""

import typer

app = typer.Typer()


def open_app(ledger: str | None) -> None:
    """Open the app on a ledger and stay until the flyer leaves it. Raises FieldkitError without a terminal."""
    import sys

    from fieldkit.errors import FieldkitError

    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise FieldkitError("the app needs a terminal; without one, the commands do all that it does: fieldkit --help")
    from fieldkit.tui.app import run

    run(ledger)


@app.command()
def tui(context: typer.Context) -> None:
    """Open the app: flights, typing in, importing, the next flight, the loop, all by keys or mouse."""
    open_app(context.find_root().obj)
