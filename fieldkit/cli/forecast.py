"""`fieldkit predict`: the next flight, for one plan or a table of them."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.options import PLAN_TEXTS, takes_plan
from fieldkit.cli.plan_options import plan_from_options, remember
from fieldkit.cli.planning import (
    OF_THE_FIELD,
    UNFOLD,
    AllChecks,
    about_plan,
    check_given_with_table,
    known_rocket,
    planned_table,
    print_basis,
    safety_of,
    way_down,
)
from fieldkit.cli.screen import (
    AsJson,
    complain,
    measured,
    print_json,
    print_table,
    progress,
    remark,
    say,
    say_wrapped,
    system,
)
from fieldkit.cli.session import MotorCheck, open_ledger
from fieldkit.errors import BadValue, LedgerError
from fieldkit.planning.check import ADVICE_NOTE, SafetyCheck
from fieldkit.quantities import in_system
from fieldkit.settings import read_settings

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from fieldkit.flight import Flight
    from fieldkit.forecast.prediction import Prediction
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue

app = typer.Typer()


class ModelVersion(StrEnum):
    """The model of a rocket before or after the loop."""

    before = "before"
    after = "after"


def predict(
    context: typer.Context,
    flights: Annotated[
        Path | None, typer.Option(help="Table of planned flights.", exists=False, show_default=False)
    ] = None,
    model: Annotated[
        ModelVersion, typer.Option(help="Without or with the effects that the loop found.")
    ] = ModelVersion.after,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="At once, if a check with the simulator confirms it; not saved, and without safety checks.",
        ),
    ] = False,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Forecast the apogee of the next flight from the rocket's normal flights."""
    from fieldkit.services.forecast_record import forecast_record

    check = MotorCheck()
    with open_ledger(context) as ledger:
        if flights is not None:
            check_given_with_table(given, OF_THE_FIELD)
        known = check.catalogue.complaint_of_several if not quick else check
        plans = planned_table(flights, known) if flights is not None else [_plan(ledger, given, check.catalogue, known)]
        if quick:
            _print_quick(ledger, check, plans, json=json)
            return
        predictions, unsaved = _predicted(ledger, check.catalogue, plans, model)
        if flights is not None:
            remember(ledger, check.catalogue, plans)
        lines = safety_of(ledger, check.catalogue, predictions, given)
        down = way_down(ledger, check.catalogue, predictions) if json else []
        rocket = ledger.rocket(plans[0].rocket)
    for note in dict.fromkeys(note for one in predictions for note in one.found.notes):
        remark(note)
    if json:
        documents = [
            forecast_record(one) | fell | about_plan(one, own)
            for one, fell, own in zip(predictions, down, lines, strict=True)
        ]
        print_json({"predictions": documents})
    elif flights is None:
        _print_one(predictions[0], ledger.remarks)
        print_basis(predictions[0].plan, lines[0], rocket, every=checks)
    else:
        _print_table(predictions)
        say()
        _print_safety_of_all(predictions, lines, every=checks)
    if unsaved is not None:
        raise LedgerError(f"saving the forecast failed: {unsaved}") from unsaved


takes_plan(predict, (*PLAN_TEXTS, "date_time"))
app.command()(predict)


def _predicted(
    ledger: "Ledger", motors: "Catalogue", plans: "Sequence[Flight]", model: ModelVersion
) -> "tuple[list[Prediction], LedgerError | None]":
    """Saved forecasts; or unsaved ones and the reason, because a flyer with a full or read-only disk needs them too."""
    from fieldkit.services.forecasts import predict_plans
    from fieldkit.services.plans import completed

    plans = completed(ledger, motors, plans, read_settings())
    with progress("fitting your other rockets") as on_progress:
        try:
            return predict_plans(ledger, motors, plans, model.value, on_progress=on_progress), None
        except LedgerError as error:
            return predict_plans(ledger, motors, plans, model.value, save="nothing", on_progress=on_progress), error


def _print_quick(ledger: "Ledger", check: MotorCheck, plans: "Sequence[Flight]", *, json: bool) -> None:
    """Print quick forecasts."""
    from fieldkit.presentation.quick_look import forecast_document, forecast_line
    from fieldkit.services.quick_look import predict_quickly

    with progress("fitting your other rockets") as on_progress:
        found = predict_quickly(ledger, check.catalogue, plans, on_progress)
    if json:
        print_json({"predictions": [forecast_document(one) for one in found]})
        return
    for one in found:
        say(forecast_line(one, system()))


def _plan(
    ledger: "Ledger", given: dict[str, str | None], motors: "Catalogue", check: "Callable[[str], str | None]"
) -> "Flight":
    """The flight described by the options; missing values, the motor too, are as last flown. Raises NoFlights,
    BadValue, BadParameter."""
    if given.get("rocket") or not given.get("motor"):
        rocket = known_rocket(ledger, given)
    if not given.get("motor"):
        last = ledger.latest(rocket)
        if last is None or not last.motor:
            raise typer.BadParameter(
                "found no --motor, expected one such as F24-4W, or --flights with a table of plans"
            )
        given = {**given, "motor": last.motor}
        remark(f"the motor is {last.motor}, as last flown; change with --motor")
    plan = plan_from_options(ledger, motors, given)
    if complaint := check(plan.motor):
        raise BadValue(f"--motor: {complaint}")
    return plan


def _print_one(prediction: "Prediction", printed_before: "Sequence[str]") -> None:
    """Print a forecast, and the flights left out of it that were not reported yet."""
    from fieldkit.presentation.forecast_text import in_words

    for line in prediction.left_out:
        if line not in printed_before:
            complain(in_system(line, system()))
    for line in in_words(prediction, system()):
        say(line)


def _print_table(predictions: "list[Prediction]") -> None:
    headers = ("flight", "config", "motor", "apogee", "5%", "95%", "eject", "model")
    rows = []
    for one in predictions:
        p05, p50, p95 = one.apogee_quantiles()
        eject = one.median_eject
        rows.append(
            (
                one.plan.flight_id,
                one.plan.config,
                one.plan.motor,
                measured("apogee", p50),
                measured("apogee", p05),
                measured("apogee", p95),
                "" if eject is None else f"{eject:+.1f} s",
                one.model,
            )
        )
    print_table(headers, rows, numbers=["apogee", "5%", "95%", "eject"])


def _print_safety_of_all(predictions: "list[Prediction]", lines: "list[list[SafetyCheck]]", *, every: bool) -> None:
    """Print the air and the safety checks of planned flights, each text once with the flights that it concerns: failed
    checks and the number of the others, or `every` check in full; and who decides."""
    from fieldkit.planning.air import air_of
    from fieldkit.presentation.safety_text import every_check, failed_checks, other_checks

    flights_of: dict[str, list[str]] = {}
    for one, own in zip(predictions, lines, strict=True):
        checks = every_check(own, system()) if every else (*failed_checks(own, system()), *other_checks(own))
        for text in (f"air {air_of(one.plan).words(system())}", *checks):
            flights_of.setdefault(text, []).append(one.plan.flight_id or one.plan.motor)
    for text, flights in flights_of.items():
        if text != ADVICE_NOTE:
            named = "every flight" if 1 < len(flights) == len(predictions) else ", ".join(flights)
            say_wrapped(f"{named}: {text}", "  ")
    say_wrapped(ADVICE_NOTE if every else f"{UNFOLD}. {ADVICE_NOTE}")
