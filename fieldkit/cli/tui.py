"""`fieldkit tui`, and `fieldkit` alone: the app. `fieldkit serve`: the same in a browser."""

import os
from typing import Annotated

import typer

from fieldkit.cli.screen import complain
from fieldkit.cli.units import in_terminal
from fieldkit.errors import FieldkitError

app = typer.Typer()


def open_app(ledger: str | None) -> None:
    """Open the app on a ledger until the user quits. Raises FieldkitError without a terminal."""
    served = "TEXTUAL_DRIVER" in os.environ  # by `fieldkit serve`: the browser is the terminal
    if not served and not in_terminal():
        raise FieldkitError("the app needs a terminal; the commands do the same: fieldkit --help")
    from fieldkit.tui.memory import pause_collection

    pause_collection()
    from fieldkit.tui.app import run

    run(ledger)


@app.command()
def tui(context: typer.Context) -> None:
    """Open the app, for keyboard or mouse: flights, entry, import, next flight, and loop."""
    open_app(context.find_root().obj)


@app.command()
def serve(
    context: typer.Context,
    host: Annotated[
        str, typer.Option(help="Address to listen on; 0.0.0.0 also serves phones on the same network.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port.")] = 8000,
) -> None:
    """Serve the app to a browser on this computer, or with --host on the network, through a link with a token."""
    import secrets

    try:
        from fieldkit.tui.serve import GuardedServer, is_loopback
    except ModuleNotFoundError as error:
        raise FieldkitError(f"serve needs {error.name}; install fieldkit[serve]") from error
    open_to_all = not is_loopback(host)
    server = GuardedServer(host, port, secrets.token_urlsafe(16), context.find_root().obj)
    if open_to_all:
        complain("warning: anyone with this link can read and change your flights; the connection is not encrypted")
    complain(f"open {server.link} in a browser; Ctrl-C stops the server")
    try:
        server.serve()
    except OSError as error:
        raise FieldkitError(f"{host}:{port}: cannot listen there ({error.strerror})") from error
