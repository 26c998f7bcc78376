"""`fieldkit mappings`: saved column mappings."""

from typing import Annotated

import typer

from fieldkit.cli.screen import AsJson, print_json, print_table, say

app = typer.Typer()


@app.command()
def mappings(
    forget: Annotated[int | None, typer.Option(help="Delete the mapping with this number.", metavar="NUMBER")] = None,
    edit: Annotated[
        int | None, typer.Option(help="Replace the mapping with this number by --map.", metavar="NUMBER")
    ] = None,
    columns: Annotated[
        list[str] | None, typer.Option("--map", metavar="CHANNEL=COLUMN", help="The new columns; needs --edit.")
    ] = None,
    json: AsJson = False,
) -> None:
    """List, change, or delete saved column mappings of tables."""
    from fieldkit.importing.tables.mapping import remembered
    from fieldkit.services.imports.mappings import edit as change
    from fieldkit.services.imports.mappings import forget as drop
    from fieldkit.services.imports.mappings import in_words

    if (edit is None) != (not columns):
        raise typer.BadParameter("found one of --edit and --map, expected both")
    if edit is not None and columns:
        change(edit, columns)
    if forget is not None:
        drop(forget)
    known = remembered()
    if json:
        rows = [
            {"number": number, "of": in_words(one)[0], "headers": list(one.headers), "map": dict(one.channels)}
            for number, one in enumerate(known, start=1)
        ]
        print_json({"mappings": rows})
    elif known:
        print_table(
            ("number", "of", "headers", "columns"),
            [(str(number), *in_words(one)) for number, one in enumerate(known, start=1)],
        )
    else:
        say("No saved mappings; `fieldkit import --map` saves one")
