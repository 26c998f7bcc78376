"""Quick answers from one linear pass: missing effects, and forecasts; nothing is saved."""

from collections.abc import Sequence
from dataclasses import dataclass

from fieldkit.errors import NoFlights, of_rocket
from fieldkit.flight import Flight
from fieldkit.forecast.at_once import prepare_at_once
from fieldkit.forecast.prediction import Prediction
from fieldkit.inference.history.check import Check, check
from fieldkit.inference.history.quick_forecast import QuickAnswer, answers
from fieldkit.ledger import Ledger
from fieldkit.model.sources import has_log
from fieldkit.motors import Catalogue, Found
from fieldkit.progress import ReportProgress, no_op
from fieldkit.quantities import counted
from fieldkit.selection.quick_look import QuickLook, quick_look
from fieldkit.services.fleet import fleet_prior
from fieldkit.services.forecasts import flown, predict_plans
from fieldkit.services.plans import completed

MIN_FLIGHTS = 4
"""Minimum number of clean flights with an apogee, the same as for the loop. [1]"""


@dataclass(frozen=True, slots=True)
class QuickForecast:
    """A plan, completed from the last flight, and the answer of a linear pass for it.

    `check` compares the answer with the model; if the check fails, or if flights show drag and impulse from a log,
    which the pass does not use, `fitted` is the fit's forecast.
    """

    plan: Flight
    found: Found
    answer: QuickAnswer
    check: Check
    fitted: Prediction | None


def look_quickly(ledger: Ledger, motors: Catalogue, rocket: str) -> QuickLook:
    """The answer of a linear pass for a rocket's flights; the model in use does not change.

    Raises NoFlights for fewer than four clean flights with an apogee, DamagedModel.
    """
    history = flown(ledger, motors, rocket)
    used_in_fit = [flight.clean and flight.apogee is not None for flight, _ in history]
    if sum(used_in_fit) < MIN_FLIGHTS:
        raise NoFlights(
            f"{rocket}: found {counted(sum(used_in_fit), 'normal flight')} with an apogee, "
            f"expected at least {MIN_FLIGHTS}"
        )
    found = quick_look(rocket, history, used_in_fit)
    if found.flights < MIN_FLIGHTS:
        raise NoFlights(
            f"{rocket}: found {counted(found.flights, 'normal flight')} with an apogee that says anything of it, "
            f"expected at least {MIN_FLIGHTS}"
        )
    return found


def predict_quickly(
    ledger: Ledger, motors: Catalogue, plans: Sequence[Flight], on_progress: ReportProgress = no_op
) -> list[QuickForecast]:
    """Forecasts of planned flights by a linear pass, each as if it flew next, or the fit's if the check by importance
    sampling fails or the flights show drag and impulse from logs; nothing is saved.

    Effects accepted in the loop and the Cds of designs are not used. Raises NoFlights for a rocket that never flew,
    UnknownMotor, ImpossibleFlight for a plan without a mass, BadValue for a file of kits or a saved model that cannot
    be read, DamagedModel if the hyperprior cannot be read.
    """
    made: list[QuickForecast] = []
    for plan, whole in zip(plans, completed(ledger, motors, plans), strict=True):
        history = flown(ledger, motors, plan.rocket)
        if not history:
            raise NoFlights(of_rocket(plan.rocket, "found no flights, expected at least one for a quick forecast"))
        before = [flight for flight, _ in history]
        found = motors.resolve(plan.motor)
        shared = fleet_prior(ledger, motors, plan.rocket, on_progress)
        used = [flight.clean for flight in before]
        ready = prepare_at_once(history, [(whole, found)], used, shared=shared)
        (answer,) = answers(ready, ready.flown)
        checked = check(answer)
        logged = any(has_log(flight) for flight in before if flight.clean)
        fitted = predict_plans(ledger, motors, [plan], save="nothing")[0] if logged or not checked.agrees else None
        made.append(QuickForecast(whole, found, answer, checked, fitted))
    return made
