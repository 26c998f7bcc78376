"""The journal: `undo`, `redo` and `history`."""

from typing import Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say
from fieldkit.cli.session import open_ledger

app = typer.Typer()


@app.command()
def undo(context: typer.Context) -> None:
    """Undo the last change; can be repeated."""
    with open_ledger(context) as ledger:
        change = ledger.undo()
    say(f"Undone: {change.command} {change.what}")


@app.command()
def redo(context: typer.Context) -> None:
    """Redo the last change that was undone."""
    with open_ledger(context) as ledger:
        change = ledger.redo()
    say(f"Redone: {change.command} {change.what}")


@app.command()
def history(
    context: typer.Context,
    last: Annotated[int | None, typer.Option(min=1, help="Only this many of the latest changes.")] = None,
    json: AsJson = False,
) -> None:
    """List all changes with their times, oldest first."""
    with open_ledger(context) as ledger:
        changes = ledger.history()[-last if last else 0 :]
        name = ledger.name
    if json:
        keys = ("number", "command", "what", "undone")
        documents = [{"at": change.at.isoformat()} | {key: getattr(change, key) for key in keys} for change in changes]
        print_json({"changes": documents})
    elif changes:
        rows = [
            (
                str(change.number),
                f"{change.at.astimezone():%Y-%m-%d %H:%M}",
                change.command,
                change.what,
                "undone" if change.undone else "",
            )
            for change in changes
        ]
        print_table(("no.", "when", "command", "what", ""), rows, numbers=["no."])
    else:
        complain(f"No changes in {name} yet")
