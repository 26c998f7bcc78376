"""A prediction as lines for a flyer, and as JSON under the keys of the contract: what, how sure, what it rests on."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from fieldkit.forecast.prediction import Prediction, median
from fieldkit.units import FOOT


def in_words(prediction: Prediction) -> Iterator[str]:
    """A prediction, a line for each thing a flyer wants to know."""
    plan, motor = prediction.plan, prediction.found.motor
    p05, p50, p95 = (float(x) for x in prediction.apogee_quantiles())
    name = " ".join(part for part in (plan.rocket, plan.config) if part) or "this rocket"
    yield f"{name} on {motor.maker} {plan.motor}, {(plan.dry_mass or 0) * 1e3:.0f} g without the motor"
    yield f"  apogee    {p50:.0f} m ({p50 / FOOT:.0f} ft) as the altimeter will show it"
    yield f"            90 % between {p05:.0f} and {p95:.0f} m ({p05 / FOOT:.0f} and {p95 / FOOT:.0f} ft)"
    yield f"  ejection  {_ejection(prediction)}"
    yield f"  Cd        {prediction.cd.mean():.2f} +/- {prediction.cd.std():.2f}"
    yield f"  alpha     {prediction.alpha.mean():.3f} +/- {prediction.alpha.std():.3f}"
    yield f"  rests on  {_rests_on(prediction)}"
    yield f"  narrows   {narrows(prediction)}"
    if prediction.earlier_forecasts:
        yield (
            f"            the interval is {prediction.stretched_by:.2f} times the model's own, as "
            f"{prediction.earlier_forecasts} earlier forecasts would have had to be"
        )


def _ejection(prediction: Prediction) -> str:
    eject = prediction.median_eject
    if eject is None:
        return "no delay known for this motor; write it with the name, such as F24-4W"
    when = "after" if eject >= 0 else "BEFORE"
    return f"{abs(eject):.1f} s {when} apogee"


def _rests_on(prediction: Prediction) -> str:
    count = prediction.rests_on
    if not count:
        return "no flight of this rocket: priors of drag and thrust alone, so the interval is wide"
    return f"{count} clean flight{'s' if count > 1 else ''}, model {prediction.model}"


def narrows(prediction: Prediction) -> str:
    """What more flights would do to the interval, and what they would not."""
    one, many = (1 - prediction.narrowed(more) for more in (1, np.inf))
    return f"by {one:.0%} after one more clean flight like it, by {many:.0%} after many"


def forecast_document(prediction: Prediction) -> dict[str, Any]:
    """A prediction under the contract's keys, and what it rests on."""
    p05, p50, p95 = prediction.apogee_quantiles()
    document: dict[str, Any] = {"flight_id": prediction.plan.flight_id} if prediction.plan.flight_id else {}
    document |= {
        "rocket": prediction.plan.rocket,
        "config": prediction.plan.config,
        "motor": prediction.plan.motor,
        "apogee_m": {
            "mean": float(prediction.apogee.mean()),
            "sd": float(prediction.apogee.std()),
            "p05": float(p05),
            "p50": float(p50),
            "p95": float(p95),
        },
        "true_apogee_m": median(prediction.true_apogee),
        "ejection_s": prediction.median_eject,
        "coast_s": median(prediction.coast),
        "top_speed_mps": median(prediction.top_speed),
        "rail_speed_mps": median(prediction.rail_speed),
        "cd": {"mean": float(prediction.cd.mean()), "sd": float(prediction.cd.std())},
        "alpha": {"mean": float(prediction.alpha.mean()), "sd": float(prediction.alpha.std())},
        "flights": prediction.rests_on,
        "model": prediction.model,
        "left_out": list(prediction.left_out),
        "interval": {
            "stretched_by": prediction.stretched_by,
            "earlier_forecasts": prediction.earlier_forecasts,
            "narrowed_by_flights": {str(more): prediction.narrowed(more) for more in (1, 3, 10)},
        },
    }
    return document
