"""Remove figures that no rocket can have, and report them as not measured, with the reason.

These are physical limits rather than habits of flyers: a mean is never above its peak, a coast rises by no more than
v²/2g, and no hobby airframe survives more than a certain acceleration. If figures contradict each other, all of them
are removed, because any may be wrong.

Derivation: conservation of energy, by which a coast without drag rises v²/2g.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import atan, erfc, exp, hypot, log1p, pi, sqrt

from fieldkit.analysis.channels import sensor
from fieldkit.analysis.notes import DOUBT, ENERGY_NOTE
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.analysis.records import Figure, Recorded
from fieldkit.flight import BY_NAME
from fieldkit.messages import amount, message, of_column
from fieldkit.physics.standard_atmosphere import GRAVITY

MAX_BOOST = 200 * GRAVITY
"""Upper limit of boost acceleration: the hardest motors lift their own casings with about 150 g. [m/s^2]"""
_CONTRADICTION_SDS = 3.0
"""Number of standard deviations beyond which figures contradict each other. [1]"""
_MOST_SDS_BELOW = 4.0
"""The same for a top speed below the one that rise and duration of the coast give: an early charge shortens a coast and
so raises that one. [1]"""
_MOST_RISE, _MOST_DRAG, _COAST_MODEL = 1.3, 1e3, 0.12
"""Largest rise of a coast relative to g t²/2, beyond which a charge has ended it; the largest drag, in weights; and the
relative error of the speed by rise and duration, because drag is not quite in proportion to v². [1]"""
_DRAG_RISE = 0.7 * 335.0
"""Speed above which drag grows faster than v², so that the coast shows its start with twice the error. [m/s]"""
_LEAST_VARIANCE = 0.01
"""Smallest fraction of a variance that a bound leaves. [1]"""
_SWINGS = 4.0
"""A curve faster than its samples by this factor does not follow a flight. [1]"""
_MAX_SMOOTHING = 2.0
"""Largest factor by which widely spaced samples underestimate the climb rate. [1]"""
_MARGIN = 1.5
"""Largest factor by which smoothed heights underestimate the speed after a short boost. [1]"""
_SLACK = 1.0
"""Uncertainty of the time of apogee, because the top of the curve is flat. [s]"""
_MAX_COAST_SD = 3.0
"""Largest standard deviation of a coast: gravity bends the top of every coast, so a top that is flat for longer is a
hover. [s]"""
LEAST_TOP_SPEED = 5.0
"""Smallest top speed of a rocket. [m/s]"""
_STATED_TOLERANCE, _READOUT_TEXTS = (
    {"apogee": 0.03, "top_speed": 0.1},
    {"apogee": "an apogee", "top_speed": "a top speed"},
)
"""Figures that devices state, and the relative error that their filters cause. [1]"""
BOOST = ("burn_time", "avg_accel", "peak_accel")
_NAMES = {
    "burn_time": "burn time",
    "avg_accel": "average acceleration",
    "peak_accel": "peak acceleration",
    "top_speed": "top speed",
    "descent_speed": "descent speed",
    "coast_to_apogee": "coast to apogee",
}
_MEASURED_FROM_ZERO = (*BOOST, "top_speed", "descent_speed")
MAX_RELATIVE_SD = 0.5
"""Largest relative standard deviation of a reported figure; beyond it zero is within two standard deviations. [1]"""


def by_energy(
    figures: Mapping[str, Figure], height_at_burnout: float | None
) -> tuple[dict[str, Figure], tuple[str, ...]]:
    """The figures with a top speed that suffices for the climb after burnout [m], whatever sensors measured it, and
    notes.

    A coast rises by at most v²/2g, so the speed is at least the root of 2 g h, which an error of burnout moves by its
    height: a normal distribution truncated there. With drag in proportion to v², the rise h and the duration t of a
    coast give the speed too. If the measured speed is short of the bound, its error is larger than stated, by Birge's
    ratio, its difference from either in standard deviations, and both are averaged by their variances. Otherwise they
    are not: the same ports move both. A top speed still farther from either contradicts the rest of the flight, and the
    boost is not reported.

    Source: Birge, The calculation of errors by the method of least squares, Physical Review 40 (1932).
    """
    speed, apogee, coast = (figures.get(name) for name in ("top_speed", "apogee", "coast_to_apogee"))
    if speed is None or apogee is None or height_at_burnout is None or speed.sd <= 0:
        return dict(figures), ()
    rise = apogee.value - height_at_burnout
    least = sqrt(2 * GRAVITY * max(rise, 0.0))
    other = speed_of_coast(rise, coast) if coast is not None else None
    beyond = (speed.value - other.value) / hypot(speed.sd, other.sd) if other else 0.0
    if other and not -_MOST_SDS_BELOW < beyond < _CONTRADICTION_SDS:
        return _without_boost(figures, speed, f"about {amount(other.value, 'm/s')}")
    burn = figures.get("burn_time")
    least_sd = GRAVITY * speed.value * burn.sd / least if burn is not None and least > 0 else 0.0
    short = (least - speed.value) / hypot(speed.sd, least_sd)
    if short > _CONTRADICTION_SDS:
        return _without_boost(figures, speed, f"at least {amount(least, 'm/s')}")
    mean = replace(speed, sd=speed.sd * max(1.0, short, abs(beyond))) if short > 0 else speed
    mean = _average(mean, other) if other and short > 0 else mean
    spread = hypot(mean.sd, least_sd)
    bounded = _beyond_bound(mean, (least - mean.value) / spread, spread)
    return _with_speed(figures, bounded), ((message(ENERGY_NOTE.format(amount(least, "m/s"))),) if short > 0 else ())


def _average(measured: Figure, other: Figure) -> Figure:
    """Two measurements of one quantity, weighted by the inverse of their variances."""
    part = measured.sd**2 / (measured.sd**2 + other.sd**2)
    value = measured.value + part * (other.value - measured.value)
    return replace(measured, value=value, sd=measured.sd * sqrt(1 - part))


def _with_speed(figures: Mapping[str, Figure], speed: Figure) -> dict[str, Figure]:
    """The figures with another top speed, and the average acceleration that belongs to it."""
    before, mean = figures["top_speed"], figures.get("avg_accel")
    if mean is None:
        return {**figures, "top_speed": speed}
    value = mean.value * speed.value / before.value
    variance = (mean.sd / mean.value) ** 2 - (before.sd / before.value) ** 2 + (speed.sd / speed.value) ** 2
    return {**figures, "top_speed": speed, "avg_accel": replace(mean, value=value, sd=value * sqrt(max(variance, 0.0)))}


def _beyond_bound(figure: Figure, short: float, spread: float, up: float = 1.0) -> Figure:
    """A figure given that a difference with this standard deviation, to which it contributes its own, is above zero, of
    which it is measured to be short by so many of these: the mean and the standard deviation of a truncated normal
    distribution. With `up` = -1 it contributes by being lower.
    """
    chance = erfc(short / sqrt(2)) / 2
    pull = exp(-(short**2) / 2) / sqrt(2 * pi) / chance
    own = figure.sd / spread
    sd = figure.sd * sqrt(max(1 - own**2 * pull * (pull - short), _LEAST_VARIANCE))
    return replace(figure, value=figure.value + up * figure.sd * own * pull, sd=sd)


def speed_of_coast(rise: float, coast: Figure) -> Figure | None:
    """The speed at the start of a coast by its rise [m] and its duration [s] with drag in proportion to v²; None if no
    drag explains both, as after an early charge. [m/s]

    With drag D times the weight at the start, the rise is ln(1 + D)/D times v²/2g, and lasts arctan(sqrt(D))/sqrt(D)
    times v/g. So the rise over g t²/2 is ln(1 + D)/arctan²(sqrt(D)), which increases with D. The error of the duration
    is that of burnout, which moves the rise too, by v; static ports that are off by s move it by s v²/2g.
    """

    def of(lasts: float, rises: float) -> float | None:
        if lasts <= 0 or not 1.0 <= 2 * rises / (GRAVITY * lasts**2) <= _MOST_RISE:
            return None
        wanted, low, high = 2 * rises / (GRAVITY * lasts**2), 1e-6, _MOST_DRAG
        for _ in range(60):
            drag = sqrt(low * high)
            low, high = (drag, high) if log1p(drag) / atan(sqrt(drag)) ** 2 < wanted else (low, drag)
        return GRAVITY * lasts * sqrt(low) / atan(sqrt(low))

    value = of(coast.value, rise)
    if value is None:
        return None
    ports = STATIC_SD * value**2 / (2 * GRAVITY) if sensor(coast.source) != "gps" else 0.0
    errors = [_COAST_MODEL * value * (2 if value > _DRAG_RISE else 1)]
    for longer, higher in ((coast.sd, value * coast.sd), (0.0, ports)):
        ends = [of(coast.value + sign * longer, rise + sign * higher) for sign in (-1, 1)]
        if ends == [None, None]:
            return None
        errors.append(max(abs(end - value) for end in ends if end is not None))
    return Figure(value, hypot(*errors), coast.source)


def _without_boost(figures: Mapping[str, Figure], speed: Figure, needed: str) -> tuple[dict[str, Figure], tuple[str]]:
    """The figures without those of the boost, because the climb after it needs another speed."""
    out = [name for name in ("top_speed", *BOOST) if name in figures]
    names = ", ".join(_NAMES[name] for name in out)
    flown = amount(speed.value, "m/s")
    why = f"not measured: {names}; {flown} do not fit the climb after burnout, which needs {needed}"
    return {name: one for name, one in figures.items() if name not in out}, (message(why),)


def possible(figures: Mapping[str, Figure]) -> tuple[dict[str, Figure], tuple[str, ...]]:
    """The figures that a rocket can have, and a phrase for each removed one.

    An average above the peak by no more than their errors is known to be below it. An impossible boost is of a burnout
    at the wrong time, unless an accelerometer felt it, and so is the coast after it.
    """
    mean, peak = figures.get("avg_accel"), figures.get("peak_accel")
    why = ""
    short = (mean.value - peak.value) / hypot(mean.sd, peak.sd) if mean and peak else 0.0
    if mean and peak and 0 < short <= _CONTRADICTION_SDS:
        spread = hypot(mean.sd, peak.sd)
        mean, peak = _beyond_bound(mean, short, spread, up=-1.0), _beyond_bound(peak, short, spread)
        figures = {**figures, "avg_accel": mean, "peak_accel": peak}
    if mean and peak and short > _CONTRADICTION_SDS:
        why = f"the average of {mean.value / GRAVITY:.3g} g would be above the peak of {peak.value / GRAVITY:.3g} g"
    strongest = max((one.value for one in (mean, peak) if one), default=0.0)
    if strongest > MAX_BOOST:
        why = f"{strongest / GRAVITY:.0f} g is more than any airframe survives"
    if not why:
        return dict(figures), ()
    burn = figures.get("burn_time")
    felt = burn is not None and sensor(burn.source) == "accel"
    out = [name for name in (*BOOST, *(() if felt else ("coast_to_apogee",))) if name in figures]
    names = ", ".join(_NAMES[name] for name in out)
    return {name: one for name, one in figures.items() if name not in out}, (f"not measured: {names}; {why}",)


def known_well(figures: Mapping[str, Figure]) -> tuple[dict[str, Figure], tuple[str, ...]]:
    """The figures whose relative standard deviation is at most one half, and a phrase for each of the others."""
    unknown = [name for name in _MEASURED_FROM_ZERO if name in figures and _is_unknown(figures[name])]
    kept = {name: one for name, one in figures.items() if name not in unknown}
    if not unknown:
        return kept, ()
    names = ", ".join(_NAMES[name] for name in unknown)
    return kept, (f"not measured: {names}; the samples give only the order of magnitude",)


def _is_unknown(figure: Figure) -> bool:
    return figure.sd > MAX_RELATIVE_SD * abs(figure.value)


def is_flight(figures: Mapping[str, Figure], height_at_burnout: float | None, highest: float, climbs: float) -> bool:
    """Whether figures are those of something that was accelerated upward and then coasted to `highest` [m].

    `climbs` is the highest climb rate of the samples [m/s], because a curve through them may oscillate. A climb that
    lasts longer or goes higher than its speed allows is an elevator, a drone, a hill or the weather. Anything slower
    than a thrown stone is not a flight either.
    """
    speed = figures.get("top_speed")
    if speed is None:
        return True
    fastest = speed.value + 2 * speed.sd
    if fastest < LEAST_TOP_SPEED:
        return False
    if height_at_burnout is None or "acceleration" in speed.source:
        return True
    if speed.value > _SWINGS * climbs:
        return False
    fastest = min(fastest, _MAX_SMOOTHING * climbs)
    coast = figures.get("coast_to_apogee")
    if coast and coast.value - _CONTRADICTION_SDS * min(coast.sd, _MAX_COAST_SD) > _MARGIN * fastest / GRAVITY + _SLACK:
        return False
    return highest - height_at_burnout < (_MARGIN * fastest) ** 2 / (2 * GRAVITY)


def widened_by_contradictions(recorded: Recorded, stated: Mapping[str, object]) -> Recorded:
    """The measurements, with larger errors if the device states a different apogee or top speed, and a note about it.

    Device and samples measure the same figure. If they differ by more than the samples' own error and more than device
    filters explain, either may be wrong, so half of the difference is added to the error in quadrature.
    """
    figures, notes = dict(recorded.figures), []
    for name, usual in _STATED_TOLERANCE.items():
        device_value, figure = stated.get(name), figures.get(name)
        if not isinstance(device_value, float) or figure is None:
            continue
        difference = abs(device_value - figure.value)
        if difference > max(_CONTRADICTION_SDS * figure.sd, usual * figure.value):
            figures[name] = replace(figure, sd=hypot(figure.sd, difference / 2))
            by_device, by_samples = (_written(name, one) for one in (device_value, figure.value))
            stated_text = f"the device states {_READOUT_TEXTS[name]} of {by_device}, the samples {by_samples}"
            notes.append(message(f"{stated_text}: {DOUBT}"))
    return replace(recorded, figures=figures, notes=(*recorded.notes, *notes)) if notes else recorded


def _written(name: str, value: float) -> str:
    """A figure [SI] with its unit, marked; one that is no column is a time."""
    return of_column(BY_NAME[name], value) if name in BY_NAME else f"{value:.4g} s"
