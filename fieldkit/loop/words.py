"""Predictions and diagnoses as lines for a flyer: what, how sure, and what it rests on."""

from collections.abc import Iterator

from fieldkit.loop.diagnose import Diagnosis
from fieldkit.loop.predict import Prediction
from fieldkit.loop.residual import fingerprint, patterns, spreads
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


def report(rocket: str, diagnosis: Diagnosis) -> Iterator[str]:
    """A diagnosis: the residual, what it goes with, the ladder of evidence, the verdict, before and after."""
    before, after = diagnosis.before, diagnosis.after
    count = int(diagnosis.data.seen[:, 0].sum())
    yield f"{rocket}: {count} clean flights, each forecast from the others by the plain model"
    yield (
        f"  error {before.mae:.1f} m in the mean, bias {before.bias:+.1f} m, "
        f"{before.coverage90:.0%} of flights in the 90 % interval"
    )
    telling = [pattern for pattern in patterns(diagnosis) if pattern.p < 0.1]
    for pattern in telling:
        yield f"  it goes with {pattern.against}: statistic {pattern.statistic:+.2f}, p {pattern.p:.3f} corrected"
    if not telling:
        yield "  it goes with nothing that was written down"
    yield ""
    yield from _fingerprints(diagnosis)
    yield ""
    yield "  could be missing                  evidence   strength"
    for item in diagnosis.ranking:
        if item.effect:
            mean, sd = item.best.strength()
            place = str(item.best.candidate.place)
            yield f"  {place:34.34}{item.log_bayes:+8.1f}   {mean:.3g} +/- {sd:.2g} {item.best.unit}"
    yield ""
    yield f"  verdict: {diagnosis.effect}: {diagnosis.why}"
    if diagnosis.effect == "none":
        chance = 1 - diagnosis.confidence
        yield f"  (the chance that something is missing is put at {chance:.0%}, before unseen flights have their say)"
    else:
        what = "something is missing" if diagnosis.effect == "unexplained" else "it is this"
        yield f"  (the chance that {what} is put at {diagnosis.confidence:.0%})"
    if diagnosis.also:
        yield f"  these flights cannot tell it from: {', '.join(diagnosis.also)}"
        for advice in diagnosis.advice:
            yield f"    to tell: {advice}"
    if diagnosis.effect != "none":
        yield (
            f"  error of flights not seen: before {before.mae:.1f} m, after {after.mae:.1f} m "
            f"(bias {before.bias:+.1f}, {after.bias:+.1f}; in the 90 % interval "
            f"{before.coverage90:.0%}, {after.coverage90:.0%})"
        )
    yield "  leave-one-flight-out, effect chosen anew inside every fold"


def _fingerprints(diagnosis: Diagnosis) -> Iterator[str]:
    """Readouts as they were off, in expected scatter, and what the likeliest effects would do to them."""
    rows = spreads(diagnosis)
    short = {
        "top_speed": "speed",
        "burn_time": "burn",
        "peak_accel": "peak",
        "coast_to_apogee": "coast",
        "apogee_to_eject": "eject s",
    }
    names = [row.readout for row in rows]
    yield f"  {'off, in its scatter':24}" + "".join(f"{short.get(n, n.replace('_', ' ')[:9]):>9}" for n in names)
    yield f"  {'mean':24}" + "".join(f"{row.bias:+9.2f}" for row in rows)
    yield f"  {'one to the next alike':24}" + "".join(f"{row.autocorrelation:+9.2f}" for row in rows)
    for item in [item for item in diagnosis.ranking if item.effect][:3]:
        marks = fingerprint(item.best)
        cells = (f"{marks[n]:+9.2f}" if n == "apogee_to_eject" else f"{marks[n]:+9.1%}" for n in names)
        yield f"  {item.effect + ' does':24}" + "".join(cells)
