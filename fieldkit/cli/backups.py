"""`fieldkit backups`: list the backups of the ledger, and restore one."""

from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say
from fieldkit.quantities import counted

if TYPE_CHECKING:
    from fieldkit.ledger.backups import Backup

app = typer.Typer()
backups = typer.Typer(invoke_without_command=True)
app.add_typer(backups, name="backups")


@backups.callback()
def list_(context: typer.Context, json: AsJson = False) -> None:
    """List the backups of the ledger, newest first; `backups restore` restores one."""
    if context.invoked_subcommand:
        return
    from fieldkit.services.backups import copies

    file, kept = copies(context.find_root().obj)
    if json:
        print_json({"backups": [_document(one) for one in kept]})
    elif kept:
        rows = [
            (
                str(one.number),
                f"{one.at.astimezone():%Y-%m-%d %H:%M}",
                "?" if one.flights is None else str(one.flights),
                str(one.changes),
                f"{one.size / 1e6:.1f} MB",
            )
            for one in kept
        ]
        print_table(("no.", "made", "flights", "changes", "size"), rows, numbers=["no.", "flights", "changes", "size"])
        complain(f"Backups of {file}")
    else:
        complain(f"No backups of {file} yet; the first is made before the first change of the day")


@backups.command()
def restore(
    context: typer.Context,
    number: Annotated[
        int | None, typer.Argument(help="Number from `fieldkit backups`; default: the newest.", show_default=False)
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Do not ask for confirmation.")] = False,
) -> None:
    """Replace the ledger with a backup. The current ledger is saved first, as the newest backup if it is sound."""
    from fieldkit.ledger.restoring import restore
    from fieldkit.services.backups import chosen_copy

    file, chosen = chosen_copy(context.find_root().obj, number)
    when = f"{chosen.at.astimezone():%Y-%m-%d %H:%M}"
    if not yes:
        typer.confirm(f"Restore backup {chosen.number} of {when}, with {_content(chosen)}?", abort=True, err=True)
    left = restore(file, chosen)
    say(f"Restored the ledger of {when}, with {_content(chosen)}")
    if left:
        complain(f"The previous ledger is saved as {left}")


def _content(backup: "Backup") -> str:
    return "an unknown number of flights" if backup.flights is None else counted(backup.flights, "flight")


def _document(backup: "Backup") -> dict[str, object]:
    about: dict[str, object] = {"number": backup.number, "at": backup.at.isoformat(), "file": str(backup.file)}
    return about | {"flights": backup.flights, "changes": backup.changes, "bytes": backup.size}
