"""A prediction as lines for a flyer: value, interval, basis."""

from collections.abc import Iterator

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.forecast.prediction import Prediction, model_in_words
from fieldkit.motors import PLUGGED_DELAY, Found
from fieldkit.motors.names import parse, with_delay
from fieldkit.quantities import ShownUnits, counted, percent, with_sd


def in_words(prediction: Prediction, system: str = "SI") -> Iterator[str]:
    """A prediction, one line per quantity, in the units of a system."""
    plan = prediction.plan
    p05, p50, p95 = prediction.apogee_quantiles()
    name = " ".join(part for part in (plan.rocket, plan.config) if part) or "this rocket"
    shown = ShownUnits(system)
    motor = motor_in_words(plan, prediction.found, plan.motor)
    yield f"{name} on {motor}, {shown.mass(plan.dry_mass or 0.0)} without the motor"
    yield f"  apogee    {shown.length(p50)} as the altimeter will show it"
    yield f"            90% interval {shown.lengths(p05, p95)}"
    yield f"  ejection  {ejection_in_words(prediction)}"
    sized = "" if plan.diameter is not None else ", for a diameter usual at its mass: its own is not given"
    yield f"  Cd        {with_sd(prediction.cd.mean(), prediction.cd.std())}{sized}"
    thrust = with_sd(prediction.alpha.mean(), prediction.alpha.std())
    yield f"  thrust    {thrust} times the certified (thrust factor, alpha)"
    yield f"  based on  {_rests_on(prediction)}"
    yield f"  narrows   {narrows(prediction)}"
    if prediction.mixed_with:
        parts = ", ".join(f"{weight:.0%} {LABELS[name]}" for name, weight in prediction.mixed_with.items())
        yield f"            mixed with simpler methods that forecast the earlier flights better: {parts}"
    if prediction.earlier_forecasts:
        yield (
            f"            the interval is {prediction.stretched_by:.2f} times the model's own, calibrated on "
            f"{counted(prediction.earlier_forecasts, 'earlier forecast')}"
        )


def motor_in_words(plan: Flight, found: Found, written: str = "") -> str:
    """Maker and motor with the delay of the flight, `AeroTech F24W-4`, or as `written` with that delay."""
    motor, delay = found.motor, plan.delay if plan.delay is not None else found.delay
    name = written or (plan.motor if motor.parts else "") or motor.designation
    if delay is not None and not motor.parts and parse(name).delay != delay:
        name = with_delay(name, delay)
    return name if parse(name).maker else f"{motor.maker} {name}"


def build_in_words(prediction: Prediction) -> str:
    """Rocket, configuration and motor: `Astra A on AeroTech F24W-4`."""
    plan = prediction.plan
    build = " ".join(part for part in (plan.rocket, plan.config) if part)
    return f"{build} on {motor_in_words(plan, prediction.found)}"


def ejection_in_words(prediction: Prediction) -> str:
    """When the charge fires, `0.5 s BEFORE apogee`, or why it does not. With dual deployment, an
    altimeter fires at apogee."""
    eject = prediction.median_eject
    if prediction.stays_on_rail:
        return "none: the rocket does not leave the rail"
    if prediction.plan.columns.recovery.dual:
        charge = "" if eject is None else f"; the motor's charge {when_it_fires(eject)}"
        return f"by an altimeter at apogee{charge}"
    if eject is not None:
        first = prediction.grounded
        grounded = f"; {percent(first)} chance of hitting the ground first" if first >= 0.01 else ""
        return when_it_fires(eject) + grounded
    plan, found = prediction.plan, prediction.found
    delay = plan.delay if plan.delay is not None else found.delay
    if delay is None:
        return "delay unknown; add it to the motor's name, as in F24-4W"
    if delay in (0, PLUGGED_DELAY):
        return f"none: a {'plugged' if delay else 'booster'} motor has no charge"
    return "none: the rocket hits the ground first"


def when_it_fires(eject: float) -> str:
    """A time after apogee [s] in words: `0.5 s BEFORE apogee`, or `at apogee` to a tenth of a second."""
    if not round(eject, 1):
        return "at apogee"
    return f"{abs(eject):.1f} s {'after' if eject >= 0 else 'BEFORE'} apogee"


def _rests_on(prediction: Prediction) -> str:
    count = prediction.rests_on
    if not count:
        return "no flights of this rocket, only other rockets"
    return f"{counted(count, 'normal flight')}, {model_in_words(prediction.model)}"


def rests_in_words(prediction: Prediction) -> str:
    """What a forecast is based on, and how much a first flight would narrow it."""
    basis = _rests_on(prediction)
    if prediction.rests_on:
        return basis
    narrower = 1 - prediction.narrowed(1)
    return f"{basis}; one normal flight would narrow the apogee by {narrower:.0%}"


def narrows(prediction: Prediction) -> str:
    """How much more flights would narrow the interval."""
    one, many = (1 - prediction.narrowed(more) for more in (1, np.inf))
    return f"by {one:.0%} after one more normal flight like this, by {many:.0%} after many"
