"""Closing the loop on a ledger: a rocket's flights diagnosed, and the result saved as a version of its model."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

from fieldkit.errors import NoFlights
from fieldkit.forecast.evaluation.rivals import rival_scores
from fieldkit.forecast.one_offs import beside_others
from fieldkit.forecast.predict import Fits
from fieldkit.ledger import Ledger
from fieldkit.model.readout_data import observe
from fieldkit.motors import Catalogue
from fieldkit.physics.history import flown_and_planned
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.quantities import counted
from fieldkit.selection.candidates import Averaged
from fieldkit.selection.diagnose import Diagnosis, diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.logged_forces import logged_forces
from fieldkit.selection.unexplained import Leftover, leftover
from fieldkit.services.findings import Findings, findings, next_flight
from fieldkit.services.flight_logs import flight_logs
from fieldkit.services.forecasts import accepted_average, assumed_of, flown
from fieldkit.services.plausible_flights import exclusions
from fieldkit.services.quick_look import MIN_FLIGHTS

SAME_PROBABILITY = 0.01
"""Two averages are the same if their probabilities differ by less than this. [1]"""


def diagnosis_of(
    ledger: Ledger,
    motors: Catalogue,
    rocket: str,
    on_progress: ReportProgress = no_op,
    given: Sequence[str] = (),
    declined: Sequence[str] = (),
) -> Diagnosis:
    """The diagnosis of a rocket's flights; nothing is saved.

    `given` are effects that the flyer knows to be present, whatever the evidence, and `declined` those known to be
    absent. Raises NoFlights for fewer than four clean flights with an apogee, UnknownEffect for a given effect that
    these flights cannot show, FieldkitError if the columns chosen for a log cannot be read.
    """
    history = flown_and_planned(flown(ledger, motors, rocket))
    used_in_fit = [flight.clean and flight.apogee is not None for flight in history.flights]
    if sum(used_in_fit) < MIN_FLIGHTS:
        raise NoFlights(
            f"{rocket}: found {counted(sum(used_in_fit), 'normal flight')} with an apogee, "
            f"expected at least {MIN_FLIGHTS} to close the loop"
        )
    history = history.using(used_in_fit)
    model, data = rocket_model(history), observe(history)
    if (count := int(data.seen[:, 0].sum())) < MIN_FLIGHTS:
        raise NoFlights(
            f"{rocket}: found {counted(count, 'normal flight')} with an apogee that says anything of it, "
            f"expected at least {MIN_FLIGHTS} to close the loop"
        )
    clean = [flight for flight, used in zip(model.flights, used_in_fit, strict=True) if used]
    forces = logged_forces(model, flight_logs(ledger, clean, part(on_progress, 0.0, 0.2)))
    return diagnose(model, data, part(on_progress, 0.2, 0.8), given, declined, forces)


def look(
    ledger: Ledger, motors: Catalogue, rocket: str, on_progress: ReportProgress = no_op, fits: Fits | None = None
) -> Findings:
    """Diagnose a rocket and collect everything for a report; nothing is saved. `fits` as in `findings_of`, errors as in
    `diagnosis_of`."""
    diagnosis = diagnosis_of(ledger, motors, rocket, part(on_progress, 0.0, 0.7))
    return findings_of(ledger, motors, rocket, diagnosis, part(on_progress, 0.7, 0.3), fits)


def findings_of(
    ledger: Ledger,
    motors: Catalogue,
    rocket: str,
    diagnosis: Diagnosis,
    on_progress: ReportProgress = no_op,
    fits: Fits | None = None,
) -> Findings:
    """Everything for a report of a rocket's diagnosis; `fits` as in `fieldkit.forecast.predict.predict`. Raises
    NoFlights if its flights were removed meanwhile, BadValue for flights that cannot be simulated, DamagedModel if the
    hyperprior cannot be read."""
    history = flown(ledger, motors, rocket)
    if not history:
        raise NoFlights(f"{rocket}: its flights were removed during the search")
    assumed = assumed_of(ledger, motors, rocket, [flight for flight, _ in history], diagnosis.averaged)
    fits = {} if fits is None else fits
    flights = beside_others(history, assumed, fits=fits)
    upcoming = next_flight(history, assumed, fits=fits)
    found = findings(rocket, diagnosis, on_progress, upcoming)
    return replace(
        found, flights=flights, rivals=rival_scores(history), excluded=tuple(exclusions(ledger.flights(rocket), motors))
    )


def adopt(ledger: Ledger, rocket: str, diagnosis: Diagnosis) -> None:
    """From now on predict a rocket with an average over the probable sets of effects of a diagnosis; does nothing if
    they are in use already. Raises BadValue for a saved model that cannot be read."""
    if in_use(ledger, rocket, diagnosis):
        return
    if all(not places for _, places in diagnosis.averaged):
        ledger.activate(rocket, None)
        return
    left = leftover(diagnosis) if diagnosis.effect == "unexplained" else None
    ledger.keep_version(rocket, version_payload(diagnosis, left))


def in_use(ledger: Ledger, rocket: str, diagnosis: Diagnosis) -> bool:
    """Whether forecasts of a rocket already use the sets of a diagnosis. Raises BadValue as `adopt`."""
    return _same(diagnosis.averaged, accepted_average(ledger, rocket))


def _same(one: Averaged, other: Averaged) -> bool:
    """Whether two averages have the same sets with the same printed probabilities."""
    plain: Averaged = ((1.0, ()),)
    first, second = ({places: chance for chance, places in some or plain} for some in (one, other))
    return first.keys() == second.keys() and all(abs(first[key] - second[key]) < SAME_PROBABILITY for key in first)


def version_payload(diagnosis: Diagnosis, left: Leftover | None = None) -> dict[str, Any]:
    """The record of a model version: effects with strengths, the sets in the average, the flights used, errors, a
    digest.

    `left` is the unexplained pattern.
    """
    payload: dict[str, Any] = {
        "effects": [
            {
                **asdict(trial.candidate.place),
                **dict(zip(("mean", "sd"), trial.strength(), strict=True)),
                "unit": trial.unit,
            }
            for trial in diagnosis.accepted
        ],
        "averaged": [
            {"probability": round(chance, 4), "places": [asdict(place) for place in places]}
            for chance, places in diagnosis.averaged
        ],
        "flights": [
            f.flight_id for f, seen in zip(diagnosis.model.flights, diagnosis.data.seen[:, 0], strict=True) if seen
        ],
        "confidence": diagnosis.confidence,
        "before": diagnosis.before.json(),
        "after": diagnosis.after.json(),
    }
    if left is not None:
        pattern = [asdict(place) for place in diagnosis.pattern]
        payload["unexplained"] = {"goes_with": left.in_words, "pattern": pattern}
    payload["digest"] = hashlib.sha256(json.dumps(payload, sort_keys=True).encode()).hexdigest()
    return payload
