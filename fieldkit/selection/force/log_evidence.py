"""The evidence of the logs, reported beside the verdict from the readouts, which it does not change."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fieldkit.analysis import Recorded
from fieldkit.model.simulated_readouts import bent
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.force.flights import FlightForce, flight_force, rocket_of
from fieldkit.selection.force.one_flight import FoundTerm
from fieldkit.selection.force.several_flights import MIN_CLIMBS, Common, common_law
from fieldkit.selection.force.terms import library

LogVerdict = Literal["", "agrees", "more", "another effect", "cannot tell", "nothing of it"]
"""How the law of the climbs compares with the verdict; `more` if the verdict names no effect, empty without a law."""


@dataclass(frozen=True, slots=True, eq=False)
class LogEvidence:
    """The missing force of the flights whose logs show it, their common law, and its comparison with the verdict.

    `silent` are the flights whose logs do not show it, each with the reason.
    """

    flights: tuple[FlightForce, ...]
    silent: tuple[tuple[str, str], ...]
    law: tuple[Common, ...]
    comparison: LogVerdict

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that the law supports."""
        return tuple(dict.fromkeys(found.term.effect for found in self.law if found.term.effect))


def compare_with_logs(diagnosis: Diagnosis, logs: Mapping[str, Recorded | str]) -> LogEvidence:
    """The evidence of the logs of clean flights, by flight id; instead of a log there may be the reason it cannot be
    read.

    They are compared with the plain model, with its drag fitted to the readouts of all flights.
    """
    model, fit = diagnosis.base.fit.model, diagnosis.base.fit
    mean, _ = fit.moments()
    areas = model.area * np.exp(bent(model, mean[None], "drag")[0])
    flights: list[FlightForce] = []
    silent: list[tuple[str, str]] = []
    for flight, found, area, used_in_fit in zip(
        model.flights, model.found, areas, diagnosis.data.seen[:, 0], strict=True
    ):
        if not used_in_fit or (recording := logs.get(flight.flight_id)) is None:
            continue
        rocket = rocket_of(flight, found.motor, float(area))
        shown = recording if isinstance(recording, str) else flight_force(flight.flight_id, recording, rocket)
        if isinstance(shown, str):
            silent.append((flight.flight_id, shown))
        else:
            flights.append(shown)
    law = common_law([one.regression for one in flights], library())
    return LogEvidence(tuple(flights), tuple(silent), law, _comparison(diagnosis.effect, law, len(flights)))


def _comparison(verdict: str, law: tuple[Common, ...], flights: int) -> LogVerdict:
    """How a law compares with a verdict."""
    if flights < MIN_CLIMBS:
        return ""
    wanted = set(verdict.split("+")) - {"none", "unexplained"}
    found = {one.term.effect for one in law} - {""}
    if wanted & found:
        return "agrees"
    effects = {term.name: term.effect for term in library()}
    if wanted & {effects[name] for one in law for name in one.also}:
        return "cannot tell"
    if found:
        return "another effect" if wanted else "more"
    return "nothing of it" if wanted & set(effects.values()) else ""


def document(evidence: LogEvidence) -> dict[str, Any]:
    """The evidence of the logs for JSON; lists are empty if no log shows a missing force."""
    return {
        "flights": [_flight(one) for one in evidence.flights],
        "silent": [{"flight_id": flight_id, "why": why} for flight_id, why in evidence.silent],
        "law": [
            {**_term(one), "flights": one.flights, "could_show": one.seen, "gain": one.gain} for one in evidence.law
        ],
        "beside_verdict": evidence.comparison or None,
    }


def _flight(one: FlightForce) -> dict[str, Any]:
    return {
        "flight_id": one.flight_id,
        "source": one.source,
        "points": [
            {
                "phase": "boost" if point.burning else "coast",
                "time_from_liftoff_s": point.time_from_liftoff,
                "speed_mps": point.speed,
                "missing_mps2": point.force,
                "sd_mps2": point.sd,
            }
            for point in one.points
        ],
        "alone": [_term(found) for found in one.law.terms],
        "explained": one.law.explained,
        "left_mps2": one.law.left,
    }


def _term(one: FoundTerm | Common) -> dict[str, Any]:
    return {
        "term": one.term.name,
        "effect": one.term.effect or None,
        "mean": one.value,
        "sd": one.sd,
        "unit": one.term.unit,
        "also": list(one.also),
    }
