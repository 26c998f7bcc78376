"""Forecasts for the rockets of a ledger, from their flights."""

import hashlib
import json
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fieldkit.errors import BadValue, NoFlights, unknown
from fieldkit.flight import Flight
from fieldkit.flight.launch_conditions import check_conditions
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.conformal import is_result, saved_surprises, stretch
from fieldkit.forecast.earlier_forecasts import EarlierForecasts
from fieldkit.forecast.evaluation.stacking import MODEL_ALONE, saved_scores, weights_after
from fieldkit.forecast.predict import Fits
from fieldkit.forecast.prediction import Prediction, quantiles
from fieldkit.ledger import Ledger, NewPrediction
from fieldkit.motors import Catalogue, Found
from fieldkit.planning.forecasts import RocketData, fitted_forecast, forecast_plans, forecasts
from fieldkit.progress import ReportProgress, no_op
from fieldkit.selection.candidates import Averaged, Place
from fieldkit.services.fleet import fleet_prior
from fieldkit.services.forecast_record import forecast_record
from fieldkit.services.kits import kit_of_rocket
from fieldkit.services.manual_entry import FLOWN_BEFORE, PLAN, setup_answers
from fieldkit.services.model_versions import version_average
from fieldkit.services.names import same_name
from fieldkit.services.plans import completed
from fieldkit.services.plausible_flights import exclusions, followed
from fieldkit.services.provenance import design_parts, digest, model_parts, plan_parts

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.forward_in_time import Forecast

QUANTILE_COUNT = 40
"""Number of equally likely apogees in a saved prediction, enough for probabilities to 2.5%. [1]"""
Which = Literal["before", "after"]
Save = Literal["nothing", "forecasts", "plan"]
"""What is saved of forecasts. With `plan`, the flyer intends to fly them: saving is a change that can be undone, and
the next flight to be entered starts from the plan."""


def flown(ledger: Ledger, motors: Catalogue, rocket: str | None = None) -> list[tuple[Flight, Found]]:
    """The flights of a rocket, or of all, that can be simulated, in order, each with its motor.

    Clusters, staged flights, flights without a dry mass or a known motor, and implausible flights are left out; the
    ledger's remarks name those without a mass or motor and the implausible ones.
    """
    flights = ledger.flights(rocket)
    ledger.remark(*exclusions(flights, motors))
    return followed(flights, motors)


def which_rocket(ledger: Ledger, wanted: str | None) -> str:
    """The named rocket, flown, with a design or planned, or the rocket of the flight entered last.

    Raises NoFlights that suggests the nearest rocket.
    """
    rockets = ledger.names("rocket")
    if wanted is not None and not ledger.rocket(wanted).configurations:
        wanted = same_name(wanted, [*rockets, *(rocket.name for rocket in ledger.rockets())])
    if wanted is not None and (wanted in rockets or ledger.rocket(wanted).configurations):
        return wanted
    if not rockets:
        found = "no flights" if wanted is None else f"no flights of {wanted!r} or any other rocket"
        raise NoFlights(f"{ledger.name}: found {found}, expected at least one; import or add flights first")
    if wanted is not None:
        raise NoFlights(unknown("rocket", wanted, rockets))
    return rockets[0]


def accepted_average(
    ledger: Ledger, rocket: str, which: Which = "after", flights: Sequence[Flight] | None = None
) -> Averaged:
    """The sets of effects in a rocket's averaged forecasts, now or before the loop; empty for the plain model.

    With `flights`, an effect whose first flight is not among them, because it was renamed or removed, starts at the
    flight in its place. Raises BadValue as `version_average`.
    """
    version = ledger.active_version(rocket) if which == "after" else None
    averaged = version_average(version.payload) if version else ()
    if version is None or flights is None:
        return averaged
    before, now = version.payload.get("flights", ()), [flight.flight_id for flight in flights]
    return tuple(
        (chance, tuple(place for one in places if (place := _started(one, before, now)))) for chance, places in averaged
    )


def _started(place: Place, before: Sequence[str], now: Sequence[str]) -> Place | None:
    """A saved effect placed among the flights `now`, given those of its model version `before`: it starts after the
    last earlier flight that still exists; None if no flight is left."""
    if place.start not in before or place.start in now:
        return place
    known = [now.index(one) for one in before[: before.index(place.start)] if one in now]
    turn = max(known, default=-1) + 1
    return place.starting_at(now[turn]) if turn < len(now) else None


def assumed_of(ledger: Ledger, motors: Catalogue, rocket: str, flights: Iterable[Flight], sets: Averaged) -> Assumed:
    """What forecasts of flights of a rocket assume beside its own, averaged over sets of effects. Raises BadValue for
    flights that cannot be simulated, DamagedModel if the hyperprior cannot be read."""
    cds = ledger.rocket(rocket).cds(flight.config for flight in flights)
    return Assumed(sets, cds=cds, shared=fleet_prior(ledger, motors, rocket))


def rocket_of(
    ledger: Ledger,
    motors: Catalogue,
    name: str,
    which: Which = "after",
    *,
    but: Flight | None = None,
    on_progress: ReportProgress = no_op,
) -> RocketData:
    """What forecasts of a rocket in a ledger are based on, read once, with or without the effects that the loop found.

    The result of the forecast of the flight `but` is not used. `on_progress` reports the fits of other rockets. Raises
    BadValue for flights that cannot be simulated, DamagedModel if the hyperprior cannot be read.
    """
    history, mount = flown(ledger, motors, name), None
    with suppress(BadValue):  # a damaged file of kits is reported where the kits are listed
        mount = kit.mount if (kit := kit_of_rocket(name)) else None
    return RocketData(
        history=tuple(history),
        averaged=accepted_average(ledger, name, which, [flight for flight, _ in history]),
        earlier=earlier_forecasts(ledger, motors, but),
        known=ledger.rocket(name),
        shared=fleet_prior(ledger, motors, name, on_progress),
        excluded=tuple(exclusions(ledger.flights(name), motors)),
        declared=which == "after",
        mount=mount,
    )


def predict_plans(
    ledger: Ledger,
    motors: Catalogue,
    plans: Sequence[Flight],
    which: Which = "after",
    *,
    save: Save = "forecasts",
    on_progress: ReportProgress = no_op,
    fits: Fits | None = None,
) -> list[Prediction]:
    """Predictions of planned flights of any rockets, in the order given, and saved in the ledger as `save` says.

    `on_progress` also reports the fits of other rockets; `fits` as in `fieldkit.forecast.predict.predict`, for plans of
    one rocket. Raises UnknownMotor, NoFlights for a plan without a rocket if none has flown, ImpossibleFlight for a
    plan without a mass, BadValue for a file of kits or a saved model that cannot be read, DamagedModel if the
    hyperprior cannot be read.
    """
    answers: dict[int, Prediction] = {}
    wholes = completed(ledger, motors, plans)
    for rocket in dict.fromkeys(plan.rocket for plan in plans):
        rows = [row for row, plan in enumerate(plans) if plan.rocket == rocket]
        planned = [(wholes[row], motors.resolve_several(wholes[row].motor)) for row in rows]
        data = rocket_of(ledger, motors, rocket, which, on_progress=on_progress)
        made = forecasts(data, planned, in_order=True, fits=fits)
        if save != "nothing":
            _keep(ledger, made, data.flights, which, as_plan=save == "plan")
        answers |= dict(zip(rows, made, strict=True))
    return [answers[row] for row in range(len(plans))]


def _keep(
    ledger: Ledger, predictions: Sequence[Prediction], history: Sequence[Flight], which: Which, *, as_plan: bool
) -> None:
    """Save predictions of one rocket, each with its inputs."""
    version = used_version(ledger, predictions[0].plan.rocket) if which == "after" else None
    for one in predictions:
        own = plan_parts(one.plan, one.found) | design_parts(
            ledger.rocket(one.plan.rocket).design(one.plan.config), one.plan
        )
        parts = own | model_parts(history, one.model, version)
        likely = quantiles(one.apogee, (np.arange(QUANTILE_COUNT) + 0.5) / QUANTILE_COUNT)
        payload: dict[str, Any] = forecast_record(one) | {
            "made_from": parts,
            "likely_m": [round(float(x), 3) for x in likely],
        }
        kept: dict[str, str] = {"digest": digest(parts), "rocket": one.plan.rocket, "flight_id": one.plan.flight_id}
        if as_plan:
            build = f"{one.plan.rocket} {one.plan.config}".strip()
            flown = [flight.flight_id for flight in ledger.flights(one.plan.rocket) if flight.readouts()]
            payload |= {PLAN: setup_answers(one.plan), FLOWN_BEFORE: [id for id in flown if id not in parts["flights"]]}
            ledger.keep_plan(payload, what=f"{build} on {one.plan.motor}", **kept)
        else:
            ledger.keep_prediction(payload, **kept)


def used_version(ledger: Ledger, rocket: str) -> int:
    """The number of a rocket's current model version, 0 for the plain model."""
    active = ledger.active_version(rocket)
    return active.number if active else 0


def keep_forecasts(ledger: Ledger, rows: "Sequence[Forecast]") -> None:
    """Save forecasts of flown flights, all or none, to calibrate the next ones."""
    ledger.keep_predictions([_kept_forecast(row) for row in rows])


def _kept_forecast(row: "Forecast") -> NewPrediction:
    payload = {
        "rocket": row.rocket,
        "flight_id": row.flight_id,
        "flown_m": float(row.flown),
        "interval_m": [float(end) for end in row.issued],
        "earlier": row.earlier,
        "log_scores": [float(score) if isfinite(score) else None for score in row.log_scores],
        "evaluation": "forward in time",
    }
    digest = hashlib.sha256(json.dumps(payload, sort_keys=True).encode()).hexdigest()
    return NewPrediction(payload, digest, row.rocket, row.flight_id)


def earlier_forecasts(ledger: Ledger, motors: Catalogue, but: Flight | None = None) -> EarlierForecasts:
    """The results of the saved forecasts of flights that are still in the ledger, clean and with the same apogee,
    except of one flight; the latest forecast of each flight counts."""
    saved = [kept.payload for kept in ledger.predictions() if is_result(kept.payload)]
    if not saved:
        return EarlierForecasts()
    left_out = (but.rocket, but.flight_id) if but else None
    flights = [one for one in ledger.flights() if (one.rocket, one.flight_id) != left_out]
    apogees = {(one.rocket, one.flight_id): one.apogee for one in flights if one.clean}
    latest = {(one["rocket"], one["flight_id"]): one for one in saved}
    judged = [one for key, one in latest.items() if apogees.get(key) == one["flown_m"]]
    surprises = saved_surprises(judged)
    later, first = (weights_after(saved_scores(judged), first=first) for first in (False, True))
    known = () if later == first == MODEL_ALONE else tuple(followed(flights, motors))
    return EarlierForecasts(len(surprises), stretch(surprises), later, first, known)


def forecast_from_others(ledger: Ledger, motors: Catalogue, flight: Flight) -> Prediction:
    """The forecast of a flight from the other flights of its rocket, as of its place in the order flown; nothing is
    saved.

    A flight that is not in the ledger is the next one. Errors as in `predict_plans`.
    """
    return from_others(rocket_of(ledger, motors, flight.rocket, but=flight), motors, flight)


def from_others(data: RocketData, motors: Catalogue, flight: Flight) -> Prediction:
    """The forecast of a flight from the other flights of its rocket, as `forecast_from_others`, from what is known of
    the rocket. Raises UnknownMotor, ImpossibleFlight for a flight without a dry mass, BadValue for a wind aloft or rail
    direction that cannot be read."""
    check_conditions(flight)
    plan = flight.unflown()
    history = list(data.history)
    planned, names = (plan, motors.resolve(flight.motor)), [one.flight_id for one, _ in history]
    turn = names.index(flight.flight_id) if flight.flight_id in names else len(names)
    if turn < len(names):
        history[turn] = planned  # it counts as flown, without its readouts
    data = replace(data, history=tuple(history), excluded=())
    (made,) = forecast_plans(data, fitted_forecast(data, [planned], flight_index=[turn]))
    return made
