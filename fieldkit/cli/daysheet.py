"""`fieldkit daysheet`: the plans of a day on one sheet."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit import files
from fieldkit.cli.options import CONDITIONS, takes_plan
from fieldkit.cli.plan_options import Given
from fieldkit.cli.planning import (
    OF_THE_FIELD,
    PlanContext,
    check_given_with_table,
    field_of,
    own_limits,
    planned_table,
    planning,
)
from fieldkit.cli.screen import complain, progress, system
from fieldkit.cli.session import MotorCheck, open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.flight import CONDITIONS as CONDITION_COLUMNS
from fieldkit.flight import MOTOR_TEMPERATURE
from fieldkit.flight.plan import check_plan
from fieldkit.flight.recovery import RECOVERY_NAMES, recovery_header
from fieldkit.quantities import counted
from fieldkit.settings import read_settings

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue

app = typer.Typer()
OF_THE_DAY = ("site", "motor_temperature", *(header.rpartition("_")[0] for header in CONDITIONS), *RECOVERY_NAMES)
"""Options of a plan that complete the flights of a table."""


def daysheet(
    context: typer.Context,
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write: .pdf, .png, .svg.", show_default=False)],
    flights: Annotated[
        Path | None, typer.Option(help="Table of planned flights; default: the one plan given here.")
    ] = None,
    title: Annotated[str, typer.Option(help="Heading of the sheet.")] = "",
    force: ForceOption = False,
    **given: str | None,
) -> None:
    """Write a day sheet: forecast, landing, and safety of every planned flight, with room for results."""
    from fieldkit.planning.planned_flight import planned_flight
    from fieldkit.presentation.report.day_sheet import day_sheet
    from fieldkit.presentation.report.finals_card import check_card

    check_card(out)
    force = settled(out, force)
    if flights is not None:
        check_given_with_table(given, (*OF_THE_FIELD, *OF_THE_DAY))
    with plans_of_day(context, flights, given) as plans:
        planned = [planned_flight(one.plan(), one.site, one.limits) for one in plans]
    heading = title or f"Day sheet, {date.today().isoformat()}"
    files.write(out, day_sheet(heading, plans[0].site, planned, out.suffix.lower(), system()), force=force)
    complain(f"Wrote the day sheet of {counted(len(planned), 'flight')} to {out}")


takes_plan(daysheet)
app.command()(daysheet)


@contextmanager
def plans_of_day(context: typer.Context, table: Path | None, given: Given) -> Iterator[list[PlanContext]]:
    """The plans of a table, each for its rocket; conditions, site and descent given on the command line fill gaps in a
    row. Without a table, the one plan that is given. The ledger is open. Raises DamagedLog, NoFlights, BadValue."""
    from fieldkit.services.forecasts import rocket_of

    if table is None:
        with planning(context, given) as plan:
            yield [plan]
        return
    check = MotorCheck()
    with open_ledger(context) as ledger, progress("planning") as on_progress:
        rows = planned_table(table, check.catalogue.complaint_of_several)
        plans = []
        for number, row in enumerate(rows):
            on_progress(f"{row.rocket or row.flight_id}", number / len(rows))
            flight = _completed_row(ledger, check.catalogue, row, given)
            rocket = rocket_of(ledger, check.catalogue, flight.rocket)
            site = field_of(ledger, flight, given)
            plans.append(PlanContext(ledger, check.catalogue, flight, rocket, site, own_limits()))
        yield plans


def _completed_row(ledger: "Ledger", motors: "Catalogue", row: "Flight", given: Given) -> "Flight":
    """A row of a table of plans, completed with the day's conditions and from its rocket."""
    from fieldkit.importing.manual_entry import read_changes
    from fieldkit.services.plans import completed_plan

    names = ("site", *(column.name for column in CONDITION_COLUMNS))
    day = read_changes(row, {name: text for name in names if (text := given.get(name)) is not None})
    open_ones = {name: value for name, value in day.items() if getattr(row, name) in (None, "")}
    extra = {recovery_header(name): text for name in RECOVERY_NAMES if (text := given.get(name))}
    if warm := given.get("motor_temperature"):
        extra[MOTOR_TEMPERATURE] = warm
    row = row.with_changes(**open_ones, extra={**extra, **row.extra})
    check_plan(row)
    return completed_plan(ledger, motors, row, read_settings())
