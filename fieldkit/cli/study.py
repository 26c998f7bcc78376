"""`fieldkit study`: pages whose figures are all computed."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from fieldkit.cli.screen import complain, progress, say_lines
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.errors import FieldkitError
from fieldkit.files import write
from fieldkit.progress import part

app = typer.Typer()
study = typer.Typer(no_args_is_help=True, help="Compute a page about the reference flights, or about your own.")
app.add_typer(study, name="study")

Out = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="Write the page to this file.", show_default="the screen")
]
Unnamed = Annotated[bool, typer.Option("--unnamed", help="Number the rockets instead of naming them.")]


@study.command()
def reference(out: Out = None, force: ForceOption = False) -> None:
    """Break the reference paper's bias down by cause, and show the remainder."""
    need_studies()
    from studies.paper.study import study
    from studies.paper.study_page import page

    force = out is not None and settled(out, force)
    _write_or_print(page(study()), out, force)


@study.command()
def rockets(context: typer.Context, out: Out = None, force: ForceOption = False, unnamed: Unnamed = False) -> None:
    """Search each rocket's history for effects, and measure how much they improve forecasts of later flights."""
    need_studies()
    from fieldkit.services.forecasts import flown
    from fieldkit.services.track_record import replayed
    from studies.histories import histories, page

    force = out is not None and settled(out, force)
    with open_ledger(context) as ledger, progress("running the loop for every rocket") as on_progress:
        motors = known_motors()
        known = {name: flown(ledger, motors, name) for name in ledger.names("rocket")}
        found = histories(known, part(on_progress, 0.0, 0.7))
        forecasts = [row for row in replayed(ledger, motors, on_progress=part(on_progress, 0.7, 0.3)) if row.earlier]
    _write_or_print(page(found, forecasts, unnamed=unnamed), out, force)


@study.command()
def shortfall(context: typer.Context, out: Out = None, force: ForceOption = False, unnamed: Unnamed = False) -> None:
    """Break down why flights fall short of simulation: launch angle, impulse, mass, drag, device."""
    need_studies()
    from fieldkit.services.forecasts import flown
    from studies.shortfall import page
    from studies.shortfall import shortfall as trace

    force = out is not None and settled(out, force)
    with open_ledger(context) as ledger, progress("tracing the shortfall") as on_progress:
        found = trace(flown(ledger, known_motors()), on_progress)
    _write_or_print(page(found, unnamed=unnamed), out, force)


def _write_or_print(page: str, out: Path | None, force: bool) -> None:
    if out is None:
        say_lines(page)
        return
    write(out, page.encode(), force=force)
    complain(f"Wrote the page to {out}")


def need_studies() -> None:
    """Raise FieldkitError that says what to install if the studies, which are not in the wheel, are missing."""
    try:
        found = find_spec("studies.paper")
    except ModuleNotFoundError:
        found = None
    if found is None:
        how = "from a checkout of fieldkit: pip install -e ."
        raise FieldkitError(f"the studies are not in the installed program; {how}")
