"""`fieldkit predict`: the next flight, for one plan or a table of them."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.options import CONDITIONS, SETUP, takes_columns
from fieldkit.cli.screen import complain, in_both_units, print_json, print_table, say
from fieldkit.cli.session import MotorCheck, open_ledger

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.ledger import Ledger
    from fieldkit.loop.predict import Prediction

app = typer.Typer()


class Which(StrEnum):
    """The model of a rocket without, or with, what the loop added."""

    before = "before"
    after = "after"


def predict(
    context: typer.Context,
    flights: Annotated[
        Path | None, typer.Option(help="A table of planned flights.", exists=False, show_default=False)
    ] = None,
    model: Annotated[Which, typer.Option(help="Without or with what the loop added.")] = Which.after,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    **given: str | None,
) -> None:
    """Predict the apogee of the next flight, from the rocket's clean flights so far."""
    from fieldkit.loop.desk import forecast_document, predict_plans, start_of

    check = MotorCheck()
    with open_ledger(context) as ledger:
        if flights is not None and given.get("motor"):
            raise typer.BadParameter("give --flights or --motor, not both")
        plans = _table(flights, check) if flights is not None else [_plan(ledger, given, check)]
        predictions = predict_plans(ledger, check.catalogue, plans, model.value)
        start = start_of(ledger, plans[0]) if flights is None else None
    if json:
        print_json({"predictions": [forecast_document(one) for one in predictions]})
    elif flights is None:
        _print_one(predictions[0])
        if start and start.cd:
            say(f"  design    its Cd starts from the {start.cd:.2f} of {start.source}")
    else:
        _print_table(predictions)


takes_columns(predict, ("motor", "config", "rocket", "site", "date_time"), (*SETUP, *CONDITIONS), "The plan")
app.command()(predict)


def _table(file: Path, check: MotorCheck) -> "list[Flight]":
    from fieldkit.intake import read_file
    from fieldkit.parsing import read_plans

    return read_plans(read_file(file), str(file), check)


def _plan(ledger: "Ledger", given: dict[str, str | None], check: MotorCheck) -> "Flight":
    """The flight that the options describe; rocket and configuration are the last flown where not said."""
    from fieldkit.entry import read_changes
    from fieldkit.errors import BadValue
    from fieldkit.flight import Flight

    changes = {name: text for name, text in given.items() if text is not None}
    if not changes.get("motor"):
        raise typer.BadParameter("found no --motor, expected one such as F24-4W, or --flights with a table of plans")
    last = ledger.latest(changes.get("rocket"))
    plan = Flight(rocket=last.rocket if last else "", config=last.config if last else "")
    plan = plan.with_changes(**read_changes(plan, changes))
    if complaint := check(plan.motor):
        raise BadValue(f"--motor: {complaint}")
    return plan


def _print_one(prediction: "Prediction") -> None:
    from fieldkit.loop.words import in_words

    for note in prediction.found.notes:
        complain(f"note: {note}")
    for line in in_words(prediction):
        say(line)


def _print_table(predictions: "list[Prediction]") -> None:
    headers = ("flight", "config", "motor", "apogee", "5 %", "95 %", "eject", "model")
    rows = []
    for one in predictions:
        p05, p50, p95 = one.apogee_quantiles()
        eject = one.median_eject
        rows.append(
            (
                one.plan.flight_id,
                one.plan.config,
                one.plan.motor,
                in_both_units("apogee", float(p50)),
                f"{p05:.0f}",
                f"{p95:.0f}",
                "" if eject is None else f"{eject:+.1f} s",
                one.model,
            )
        )
    print_table(headers, rows, numbers=["apogee", "5 %", "95 %", "eject"])
