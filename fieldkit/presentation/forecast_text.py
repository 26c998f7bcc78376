"""A prediction as lines for a flyer: what, how sure, what it rests on."""

from collections.abc import Iterator

import numpy as np

from fieldkit.forecast.prediction import Prediction
from fieldkit.quantities import ShownUnits, counted
from fieldkit.units import FOOT


def in_words(prediction: Prediction, system: str | None = None) -> Iterator[str]:
    """A prediction, a line for each thing a flyer wants to know; in the units of a system, in meters and feet without
    one."""
    plan, motor = prediction.plan, prediction.found.motor
    p05, p50, p95 = (float(x) for x in prediction.apogee_quantiles())
    name = " ".join(part for part in (plan.rocket, plan.config) if part) or "this rocket"
    shown = ShownUnits(system or "SI")
    yield f"{name} on {motor.maker} {plan.motor}, {shown.mass(plan.dry_mass or 0.0)} without the motor"
    feet = ["", ""] if system else [f" ({p50 / FOOT:.0f} ft)", f" ({p05 / FOOT:.0f} to {p95 / FOOT:.0f} ft)"]
    yield f"  apogee    {shown.length(p50)}{feet[0]} as the altimeter will show it"
    yield f"            90 % interval {shown.lengths(p05, p95)}{feet[1]}"
    yield f"  ejection  {_ejection(prediction)}"
    yield f"  Cd        {prediction.cd.mean():.2f} +/- {prediction.cd.std():.2f}"
    yield f"  alpha     {prediction.alpha.mean():.3f} +/- {prediction.alpha.std():.3f}"
    yield f"  based on  {_rests_on(prediction)}"
    yield f"  narrows   {narrows(prediction)}"
    if prediction.earlier_forecasts:
        yield (
            f"            the interval is {prediction.stretched_by:.2f} times the model's own, calibrated on "
            f"{counted(prediction.earlier_forecasts, 'earlier forecast')}"
        )


def _ejection(prediction: Prediction) -> str:
    eject = prediction.median_eject
    if eject is None:
        return "delay unknown; add it to the motor's name, as in F24-4W"
    when = "after" if eject >= 0 else "BEFORE"
    return f"{abs(eject):.1f} s {when} apogee"


def _rests_on(prediction: Prediction) -> str:
    count = prediction.rests_on
    if not count:
        return "no flights of this rocket: priors only, so the interval is wide"
    return f"{counted(count, 'clean flight')}, model {prediction.model}"


def rests_in_words(prediction: Prediction) -> str:
    """What a forecast rests on, and without a flight what one would narrow."""
    count = prediction.rests_on
    if count:
        return f"{counted(count, 'clean flight')}, model {prediction.model}"
    narrower = 1 - prediction.narrowed(1)
    return f"no flights of this rocket, only other rockets; one clean flight would narrow the apogee by {narrower:.0%}"


def narrows(prediction: Prediction) -> str:
    """What more flights would do to the interval, and what they would not."""
    one, many = (1 - prediction.narrowed(more) for more in (1, np.inf))
    return f"by {one:.0%} after one more clean flight like this, by {many:.0%} after many"
