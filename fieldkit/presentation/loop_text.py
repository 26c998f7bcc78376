"""A closed loop as lines for a flyer: what is missing, how sure that is, and what it rests on."""

from collections.abc import Iterator
from math import isfinite

from fieldkit.selection.force.text import climbs_in_words
from fieldkit.services.findings import Findings


def report(found: Findings) -> Iterator[str]:
    """A closed loop: the residual, what it goes with, the ladder of evidence, the verdict, before and after."""
    diagnosis = found.diagnosis
    yield from _residual(found)
    yield ""
    yield from _fingerprints(found)
    yield ""
    yield "  could be missing                  evidence  steady   strength"
    for item in diagnosis.ranking:
        if item.effect:
            mean, sd = item.best.strength()
            place = str(item.best.candidate.place)
            yield f"  {place:34.34}{item.log_bayes:+8.1f}{item.steady:+8.1f}   {mean:.3g} +/- {sd:.2g} {item.best.unit}"
    yield ""
    yield from _verdict(found)
    for line in climbs_in_words(found.testimony):
        yield f"  {line}"
    for line in found.implausible:
        yield f"  {line}"
    yield ""
    yield from _errors(found)


def _residual(found: Findings) -> Iterator[str]:
    before = found.left_out.before.score
    count = found.left_out.before.flights
    yield f"{found.rocket}: {count} clean flights, each forecast from the others by the plain model"
    yield (
        f"  error {before.mae:.1f} m in the mean, bias {before.bias:+.1f} m, "
        f"{before.coverage90:.0%} of flights in the 90 % interval"
    )
    telling = [row for row in (*found.patterns, *found.readout_patterns) if row.p < 0.1]
    for row in telling:
        what = "it goes" if row.readout == "apogee" else f"{row.readout.replace('_', ' ')} goes"
        yield f"  {what} with {row.against}: statistic {row.statistic:+.2f}, p {row.p:.3f} corrected"
    for spread in found.spreads:
        if spread.autocorrelation_p < 0.05:
            yield (
                f"  {spread.readout.replace('_', ' ')} is off alike from one flight to the next: "
                f"{spread.autocorrelation:+.2f}, p {spread.autocorrelation_p:.3f}"
            )
    if not telling:
        yield "  it goes with nothing that was written down"


def _verdict(found: Findings) -> Iterator[str]:
    diagnosis = found.diagnosis
    yield f"  verdict: {diagnosis.effect}: {diagnosis.why}"
    if found.unexplained is not None:
        yield f"  {found.unexplained.in_words}"
        yield f"  forecasts are given intervals {found.unexplained.widened:.2f} times as wide"
    if diagnosis.effect == "none":
        chance = _chance(1 - diagnosis.confidence)
        yield f"  (the chance that something is missing is put at {chance}, before unseen flights have their say)"
    else:
        what = "something is missing" if diagnosis.effect == "unexplained" else "it is this"
        yield f"  (the chance that {what} is put at {_chance(diagnosis.confidence)})"
    if diagnosis.also:
        yield f"  these flights cannot tell it from: {', '.join(diagnosis.also)}"
        for test in found.tests:
            yield f"    to tell: {test.in_words}"


def _chance(share: float) -> str:
    """A probability in per cent; of none it is said that it is certain."""
    return f"{share:.0%}" if 0.01 <= share <= 0.99 else "more than 99%" if share > 0.5 else "less than 1%"


def _errors(found: Findings) -> Iterator[str]:
    """Errors before and after, left out and forward in time, with their intervals."""
    yield f"  {'error of unseen flights':24}{'MAE':>5} {'[m]':14}{'RMSE':>6}{'bias':>6} {'':14}{'in 90%':>6}"
    for title, compared in (("left out", found.left_out), ("forward in time", found.forward)):
        if not compared.before.flights:
            continue
        rows = [("before", compared.before)] + [("after", compared.after)] * (found.diagnosis.effect != "none")
        for when, judged in rows:
            score, (low, high), (least, most) = judged.score, judged.mae, judged.bias
            yield (
                f"  {title + ', ' + when:24}{score.mae:5.1f} {f'({low:.1f} to {high:.1f})':14}"
                f"{score.rmse:6.1f}{score.bias:+6.1f} {f'({least:+.0f} to {most:+.0f})':14}{score.coverage90:6.0%}"
            )
    yield f"  left out: {found.left_out.how}"
    yield f"  forward: {found.forward.how}"
    yield "  in brackets: 90 % intervals over the flights (bootstrap)"


def _signed(figure: float) -> str:
    """A figure in a column of nine, a dash where there is none: residuals all alike, or too few of them."""
    return f"{figure:+9.2f}" if isfinite(figure) else f"{'-':>9}"


def _fingerprints(found: Findings) -> Iterator[str]:
    """Readouts as they were off, in expected scatter, and what the likeliest effects would leave there."""
    short = {
        "top_speed": "speed",
        "burn_time": "burn",
        "peak_accel": "peak",
        "coast_to_apogee": "coast",
        "apogee_to_eject": "eject s",
    }
    names = [row.readout for row in found.spreads]
    yield f"  {'off, in its scatter':24}" + "".join(f"{short.get(n, n.replace('_', ' ')[:9]):>9}" for n in names)
    yield f"  {'mean':24}" + "".join(_signed(row.bias) for row in found.spreads)
    yield f"  {'one to the next alike':24}" + "".join(_signed(row.autocorrelation) for row in found.spreads)
    for trial, row in found.fingerprints:
        marks = {mark.readout: mark for mark in row}
        yield f"  {trial.candidate.effect + ' leaves':24}" + "".join(_signed(marks[n].expected) for n in names)
        yield f"  {'  and there was':24}" + "".join(_signed(marks[n].found) for n in names)
