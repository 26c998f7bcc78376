"""A quick search as JSON under the contract's keys, and as lines for a flyer."""

from collections.abc import Iterator
from shlex import quote
from typing import Any

import numpy as np

from fieldkit.forecast.prediction import Prediction, median
from fieldkit.inference.history.quick_forecast import MODEL, QuickAnswer
from fieldkit.presentation.json_values import finite
from fieldkit.presentation.loop_text import candidate_row
from fieldkit.quantities import ShownUnits, counted, in_system, strength_in_words
from fieldkit.selection.quick_look import QuickLook
from fieldkit.services.forecast_record import apogee_summary
from fieldkit.services.quick_look import QuickForecast

EVALUATION = "amortized"
"""The name that scripts know for an answer without a search."""
READOUT_KEYS = {"ejection_s": "apogee_to_eject", "coast_s": "coast_to_apogee", "top_speed_mps": "top_speed"}
"""Other forecast medians by their keys in JSON."""


def quick_document(found: QuickLook) -> dict[str, Any]:
    """The keys of a closed loop, with probabilities instead of a search."""
    before, chances = finite(found.before.json()), found.probabilities
    low, middle, high = (found.again.apogee_at(level) for level in (0.05, 0.5, 0.95))
    return {
        "rocket": found.rocket,
        "n_flights": found.flights,
        "base_model": "field",
        "model": MODEL,
        "residual": {"before": before, "pattern": []},
        "probabilities": {"none": chances.none, "unexplained": chances.unexplained, **chances.inclusion},
        "candidates": [
            {
                "effect": one.effect,
                "probability": one.probability,
                "evidence": one.log_bayes,
                "parameters": {one.place: {"mean": one.mean, "sd": one.sd, "unit": one.unit}},
                "after": {key: finite(one.after.json())[key] for key in ("mae_m", "rmse_m", "bias_m")},
            }
            for one in found.candidates
        ],
        "verdict": {"effect": found.effect, "confidence": found.confidence, "why": found.why, "also": list(found.also)},
        "before": before,
        "after": finite(found.after.json()),
        "same_flight_again": {"apogee_m": {"p05": low, "p50": middle, "p95": high}},
        "provisional": True,
        "evaluation": EVALUATION,
    }


def quick_lines(found: QuickLook, system: str = "SI") -> Iterator[str]:
    """Probabilities in descending order, and the verdict, in the units of a system."""
    chances = found.probabilities
    yield f"{found.rocket}: {counted(found.flights, 'normal flight')}; nothing is saved"
    yield "  provisional: in 21% of simulated seasons the full search has another verdict, mostly a name"
    missed = ShownUnits(system).length(found.before.mae, 1)
    yield f"  mean miss without a correction, each flight forecast from the others: {missed}"
    yield ""
    yield "  effect                            probability  evidence   strength"
    yield from candidate_row("none", f"{chances.none:11.0%}")
    yield from candidate_row("unexplained", f"{chances.unexplained:11.0%}")
    for one in found.candidates:
        strength = strength_in_words(one.mean, one.sd, one.unit, system)
        yield from candidate_row(one.place, f"{one.probability:11.0%}{one.log_bayes:+10.1f}   {strength}")
    yield ""
    yield f"  verdict: {found.effect} ({found.confidence:.0%}): {in_system(found.why, system)}"
    if found.also:
        yield f"  or {', '.join(found.also)}, which these flights do not rule out"
    yield f"  `fieldkit loop --rocket {quote(found.rocket)}` runs the full search and saves the result"


def forecast_document(found: QuickForecast) -> dict[str, Any]:
    """A forecast under the contract's keys; `cd` refers to the body's frontal area, or to the area assumed for its
    mass."""
    checked = found.check
    return {
        "flight_id": found.plan.flight_id,
        "motor": found.plan.motor,
        "config": found.plan.config,
        **(_by_the_pass(found.answer) if found.fitted is None else _by_the_fit(found.fitted)),
        "check": {
            "agrees": checked.agrees,
            "pareto_k": checked.pareto_k if np.isfinite(checked.pareto_k) else None,
            "effective": {"parameters": checked.parameters_effective, "apogee": checked.apogee_effective},
            "draws": checked.draws,
        },
    }


def _by_the_pass(answer: QuickAnswer) -> dict[str, Any]:
    draws = answer.apogees
    low, middle, high = (answer.apogee_at(level) for level in (0.05, 0.5, 0.95))
    return {
        "apogee_m": {"mean": float(draws.mean()), "sd": float(draws.std()), "p05": low, "p50": middle, "p95": high},
        **{key: answer.readouts[name][1] if name in answer.readouts else None for key, name in READOUT_KEYS.items()},
        "cd": {"median": float(np.exp(answer.log_cd[0])), "log_sd": answer.log_cd[1]},
        "alpha": {"median": float(np.exp(answer.log_alpha[0])), "log_sd": answer.log_alpha[1]},
        "rests_on": answer.rests_on,
        "model": MODEL,
        "evaluation": EVALUATION,
    }


def _by_the_fit(prediction: Prediction) -> dict[str, Any]:
    return {
        "apogee_m": apogee_summary(prediction),
        "ejection_s": prediction.median_eject,
        "coast_s": median(prediction.coast),
        "top_speed_mps": median(prediction.top_speed),
        "cd": {"median": float(np.median(prediction.cd)), "log_sd": float(np.log(prediction.cd).std())},
        "alpha": {"median": float(np.median(prediction.alpha)), "log_sd": float(np.log(prediction.alpha).std())},
        "rests_on": prediction.rests_on,
        "model": prediction.model,
        "evaluation": "fit",
    }


def forecast_line(found: QuickForecast, system: str = "SI") -> str:
    """A forecast in one line, and whether it comes from a linear pass or the fit."""
    shown = ShownUnits(system)
    answer = _by_the_pass(found.answer) if found.fitted is None else _by_the_fit(found.fitted)
    apogee = answer["apogee_m"]
    name = f"{found.plan.flight_id}: " if found.plan.flight_id else ""
    source = "at once, checked with the simulator"
    if found.fitted is not None and found.check.agrees:
        source = "by the fit, because a quick answer does not use drag and impulse from logs"
    elif found.fitted is not None:
        source = "by the fit, because the quick answer failed its check"
    return (
        f"{name}{found.plan.motor}: {shown.length(apogee['p50'])}, 90% interval "
        f"{shown.lengths(apogee['p05'], apogee['p95'])}, "
        f"{source}; Cd {answer['cd']['median']:.2f}, thrust {answer['alpha']['median']:.2f} times certified"
    )
