"""`fieldkit kits`: the flyer's kits."""

from typing import Annotated

import typer

from fieldkit.cli.numbers import length, typed
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, system
from fieldkit.flight import BY_NAME
from fieldkit.quantities import measure, unit_of

app = typer.Typer()


@app.command()
def kits(
    name: Annotated[str | None, typer.Argument(help="Name of the kit to show, save, or delete.")] = None,
    dry_mass: Annotated[str | None, typer.Option(help="Ready to fly, without the motor: 80g, 2.8oz.")] = None,
    diameter: Annotated[str | None, typer.Option(help="The widest tube of its body: 41.6mm, 1.64in.")] = None,
    mount: Annotated[str | None, typer.Option(help="The widest motor that its mount takes: 18mm, 0.71in.")] = None,
    delete: Annotated[bool, typer.Option("--delete", help="Delete the kit.")] = False,
    json: AsJson = False,
) -> None:
    """List your kits, or save or delete one; plans use them with --kit."""
    from fieldkit.planning.kits import KIT_KEYS, Kit
    from fieldkit.services.kits import delete_kit, named_kit, save_kit
    from fieldkit.services.kits import kits as own_kits

    given = {"diameter": length("--diameter", diameter, "mm"), "mount": length("--mount", mount, "mm")}
    given["dry_mass"] = None if dry_mass is None else typed("--dry-mass", dry_mass, "mass", "g")
    changes = {key: value for key, value in given.items() if value is not None}
    if name is None and (changes or delete):
        raise typer.BadParameter("found no name, expected that of a kit first")
    if delete and changes:
        raise typer.BadParameter("use --delete or figures, not both")
    if name is not None and delete:
        delete_kit(name)
        complain(f"Deleted the kit {name}")
        return
    if name is not None and changes:
        old = next((one for one in own_kits() if one.name.casefold() == name.casefold()), None)
        figures = (changes.get(key, getattr(old, key, None)) for key in ("dry_mass", "diameter", "mount"))
        save_kit(Kit(old.name if old else name, *figures), old.name if old else "")
    known = [named_kit(name)] if name is not None else own_kits()
    if json:
        documents = [
            {"kit": one.name} | {key: _shown(value) for key, value in zip(KIT_KEYS, one.figures, strict=True)}
            for one in known
        ]
        print_json({"kits": documents})
        return
    if not known:
        complain("No kits yet; `fieldkit kits NAME --dry-mass 80g --diameter 41.6mm --mount 18mm` saves one")
        return
    metric = unit_of(BY_NAME["diameter"], system()) == "mm"
    rows = [
        (
            one.name,
            measure(BY_NAME["dry_mass"], one.dry_mass, system()),
            _millimeters(one.diameter) if metric else measure(BY_NAME["diameter"], one.diameter, system()),
            _millimeters(one.mount),
        )
        for one in known
    ]
    print_table(("kit", "dry mass", "diameter", "mount"), rows, numbers=["dry mass", "diameter", "mount"])


def _millimeters(value: float | None) -> str:
    """A width [m] in millimeters, with four significant digits; empty if it is unknown."""
    return "" if value is None else f"{value * 1e3:.4g} mm"


def _shown(value: float | None) -> float | None:
    """A mass or a diameter for JSON, in g or mm."""
    return None if value is None else round(value * 1e3, 6)
