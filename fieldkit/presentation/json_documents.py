"""The results of the loop and the scores of forecasts as JSON under the keys of the contract."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.forecast.prediction import LEVELS, quantiles
from fieldkit.presentation.json_values import finite
from fieldkit.presentation.loop_text import in_odds, misses, what_accepting_changes
from fieldkit.presentation.one_off_text import why
from fieldkit.scoring.proper_scores import crps, pit
from fieldkit.selection.diagnose import Ranked
from fieldkit.selection.drag_steps import FlightDrag
from fieldkit.selection.logged_forces import LoggedForces, ThrustProfile
from fieldkit.selection.next_experiment import Advice
from fieldkit.selection.residual import fingerprint
from fieldkit.services.findings import CANDIDATE_EVALUATION, Compared, Findings

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.comparison import ScoreReport
    from fieldkit.forecast.evaluation.forward_in_time import Forecast
    from fieldkit.services.scores import LedgerScores

FORWARD_NOTE = "forward in time: each flight from the earlier ones of its rocket and of all others"
MIDDLES = {"certified": "uncalibrated", "persistence": "flight_before", "scaled": "scalar", "repeated": "last_on_motor"}
"""Keys of the rivals' medians, unchanged since the first version."""


def loop_document(found: Findings) -> dict[str, Any]:
    """A diagnosis under the contract's keys, with further details."""
    diagnosis = found.diagnosis
    before = finite(found.left_out.before.json())
    return {
        "rocket": found.rocket,
        "n_flights": int(diagnosis.data.seen[:, 0].sum()),
        "base_model": "field",
        "residual": {
            "before": before,
            "pattern": [asdict(row) for row in found.patterns],
            "pattern_of_readouts": [asdict(row) for row in found.readout_patterns],
            "readouts": [finite(asdict(row)) for row in found.spreads],
        },
        "candidates": [_candidate(item) for item in diagnosis.ranking if item.effect],
        "candidates_evaluation": CANDIDATE_EVALUATION,
        "verdict": _verdict(found),
        "probabilities": _probabilities(found),
        "before": before,
        "after": finite(found.left_out.after.json()),
        "gain_m": _gain(found.left_out),
        "evaluation": found.left_out.how,
        "forward": _forward(found),
        "fingerprints": [
            {"effect": str(trial.candidate.place), "readouts": [finite(asdict(mark)) for mark in row]}
            for trial, row in found.fingerprints
        ],
        "implausible": list(found.excluded),
        "misses": misses(found),
        "rivals": [asdict(rival) for rival in found.rivals],
        "flights": [finite(flight_document(one) | _forces(one, found.diagnosis.forces)) for one in found.flights],
    }


def flight_document(one: FlightBesideOthers) -> dict[str, Any]:
    """A flight beside its forecast from the others."""
    return {
        "flight_id": one.flight.flight_id,
        "miss_m": one.miss,
        "miss_sd_m": one.miss_sd,
        "one_off": {
            "probability": one.probability,
            "causes": [asdict(cause) for cause in one.causes],
            "suggested_tags": list(one.suggested_tags),
            "why": why(one),
        },
    }


def _forces(one: FlightBesideOthers, forces: LoggedForces | None) -> dict[str, Any]:
    """Thrust and drag along the log of a flight, and the steps of its drag; empty without a log."""
    name = one.flight.flight_id
    if forces is None or name not in forces.drag:
        return {"no_forces": forces.silent[name]} if forces is not None and name in forces.silent else {}
    drag, thrust = forces.drag[name], forces.thrust.get(name)
    steps = [
        {"from_s": step.begin, "to_s": step.end, "ratio": step.ratio, "sd": step.sd, "probability": step.probability}
        for step in drag.steps
    ]
    return {"drag": _along(drag), "thrust": _along(thrust) if thrust is not None else [], "steps": steps}


def _along(profile: FlightDrag | ThrustProfile) -> list[dict[str, float]]:
    rows = zip(profile.time_from_liftoff, profile.ratio, profile.sd, strict=True)
    return [{"time_from_liftoff_s": float(t), "ratio": float(r), "sd": float(s)} for t, r, s in rows]


def _candidate(item: Ranked) -> dict[str, Any]:
    place, strength = str(item.best.candidate.place), dict(zip(("mean", "sd"), item.best.strength(), strict=True))
    return {
        "effect": item.effect,
        "evidence": item.log_bayes,
        "probability": item.probability,
        "parameters": {place: {**strength, "unit": item.best.unit}},
        "fingerprint": fingerprint(item.best),
        "after": {key: item.score.json()[key] for key in ("mae_m", "rmse_m", "bias_m")},
    }


def _verdict(found: Findings) -> dict[str, Any]:
    diagnosis, change = found.diagnosis, found.next_flight.after - found.next_flight.before
    return {
        "effect": diagnosis.effect,
        "confidence": diagnosis.confidence,
        "why": diagnosis.why,
        "odds": in_odds(diagnosis.confidence),
        "fits": {"p": diagnosis.fits.p, "left": diagnosis.fits.left},
        "also": list(diagnosis.also),
        "accepting": list(what_accepting_changes(found)),
        "tell_apart": [_test(test) for test in found.tests],
        "goes_with": found.unexplained.in_words if found.unexplained else None,
        "next_flight": {
            "motor": found.next_flight.flight.motor,
            "config": found.next_flight.flight.config,
            "before_m": found.next_flight.before,
            "after_m": found.next_flight.after,
            "change_m": change,
            "change_percent": 100 * change / found.next_flight.before,
            "interval90_m": list(found.next_flight.interval),
        },
    }


def _probabilities(found: Findings) -> dict[str, Any]:
    """The posterior: probabilities of each effect, of no effect, and of the sets in averaged forecasts."""
    diagnosis = found.diagnosis
    likely = [(members, chance) for members, chance in diagnosis.posterior.sets.items() if chance >= 0.005]
    return {
        "none": diagnosis.posterior.nothing,
        "effects": diagnosis.posterior.inclusion,
        "sets": [{"effects": sorted(members), "probability": chance} for members, chance in likely],
        "averaged": [
            {"places": [str(place) for place in places], "probability": chance} for chance, places in diagnosis.averaged
        ],
    }


def _test(test: Advice) -> dict[str, Any]:
    return {
        "do": test.what,
        "write_down": list(test.readouts),
        "expected_log_bayes_factor": test.expected,
        "in_words": test.in_words,
    }


def _forward(found: Findings) -> dict[str, Any]:
    """The forecasts of flights from earlier ones, and the set chosen for each."""
    chosen = zip(found.diagnosis.model.flights, found.ahead.chosen, found.ahead.seen, strict=True)
    return {
        "n_flights": found.forward.before.flights,
        "before": finite(found.forward.before.json()),
        "after": finite(found.forward.after.json()),
        "gain_m": _gain(found.forward),
        "chosen": [
            {"flight_id": flight.flight_id, "effect": name or "none"} for flight, name, judged in chosen if judged
        ],
        "evaluation": found.forward.how,
    }


def _gain(compared: Compared) -> dict[str, Any]:
    return {"mae_m": finite(compared.gain), "interval90": finite(compared.gain_interval)}


def score_document(found: "ScoreReport") -> dict[str, Any]:
    """The scores of forecasts replayed forward in time."""
    from fieldkit.forecast.evaluation.forward_in_time import (
        corrected_coverage,  # takes 50 ms to import; only `score` prints it
    )

    return {
        "flights": [_forecast(row) for row in found.rows],
        "errors": [asdict(way) for way in found.ways],
        "coverage90": found.coverage90,
        "corrected": corrected_coverage(found.rows),
        "evaluation": FORWARD_NOTE,
        **found.json(),
    }


def scores_document(found: "LedgerScores") -> dict[str, Any]:
    """The scores of flights with an earlier one of their rocket; under `first_flights` of first flights, under `saved`
    of saved forecasts, with the same keys."""
    own = score_document(found.first) | {
        "evaluation": "forward in time: each flight from the earlier ones of other rockets"
    }
    stacking = {"weights": dict(found.weights), "weights_of_first": dict(found.weights_of_first)}
    document = {**score_document(found.later), "first_flights": own, "stacking": stacking}
    saved = None
    if found.saved is not None:
        saved = score_document(found.saved) | {"evaluation": "as predicted before the flight", "stale": found.stale}
        del saved["corrected"]
    whole: dict[str, Any] = finite({**document, "saved": saved})
    return whole


def _forecast(row: "Forecast") -> dict[str, Any]:
    rivals = {name: quantiles(draws, LEVELS).tolist() for name, draws in row.rivals.items()}
    return {
        "rocket": row.rocket,
        "flight_id": row.flight_id,
        "motor": row.motor,
        "earlier": row.earlier,
        "flown": row.flown,
        "p05": row.p05,
        "p50": row.p50,
        "p95": row.p95,
        **{key: rivals[name][1] if name in rivals else None for key, name in MIDDLES.items()},
        "when": row.when.isoformat() if row.when else None,
        "stretch": row.stretch,
        "corrected": row.corrected,
        "pit": pit(row.draws, row.flown),
        "crps": crps(row.draws, row.flown),
        "rivals": {name: dict(zip(("p05", "p50", "p95"), ends, strict=True)) for name, ends in rivals.items()},
    }
