"""A closed loop as lines for a flyer: what is missing, its probability, the evidence, how well forecasts are that a fit
did not see, and what logs show of drag."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from fieldkit.flight.short_name import flight_label
from fieldkit.physics.effect import effects, spoken
from fieldkit.presentation.one_off_text import one_off_lines
from fieldkit.quantities import ShownUnits, counted, in_system, percent, strength_in_words, with_sd
from fieldkit.selection.candidates import Place
from fieldkit.selection.diagnose import MIN_AVERAGED, left_out_of_average
from fieldkit.selection.drag_steps import DragStep
from fieldkit.selection.logged_forces import LoggedForces
from fieldkit.selection.recorded_columns import column_in_words, misses_of
from fieldkit.selection.verdict import MATCH_PROBABILITY
from fieldkit.services.findings import Compared, Findings, RepeatedFlight

BARS = "▁▂▃▄▅▆▇█"
"""Characters of the bars, from zero to the largest miss."""
MAX_DRAWN = 60
"""Number of latest flights whose misses are drawn. [1]"""
NAME_WIDTH = 34
"""Width of the names in the table of effects, in characters."""
NOT_BETTER = ": none makes forecasts of flights left out better"
"""Why forecasts stay without a correction although something may be missing."""
MIN_CHANCE_LISTED = 0.01
"""Probability from which an effect is listed in the short report. [1]"""
MAX_P_SHOWN = 0.1
"""Corrected p-value below which a pattern in the residuals is listed. [1]"""


def report(found: Findings, system: str = "SI", *, details: bool = False) -> Iterator[str]:
    """A closed loop in the units of a system: the verdict, the misses before and after, and the probable effects; with
    `details` every effect with its evidence, the residuals and the held-out errors."""
    shown, count = ShownUnits(system), found.left_out.before.flights
    yield f"{found.rocket}: {counted(count, 'normal flight')}"
    yield f"  verdict: {found.diagnosis.effect}: {in_system(found.diagnosis.why, system)}"
    for line in (*beside_verdict(found, system), *found.excluded):
        yield f"  {line}"
    yield ""
    yield from misses_drawn(found, system)
    yield from mean_misses(found, shown)
    yield ""
    if odd := list(one_off_lines(found.flights, system)):
        yield from (f"  {line}" for line in odd)
        yield ""
    yield from _effects(found, system, every=details)
    if details:
        yield ""
        yield from _residual(found, shown)
        yield ""
        yield from _fingerprints(found)
        yield ""
        yield from _errors(found, shown)


def _effects(found: Findings, system: str, *, every: bool) -> Iterator[str]:
    """The effects with their probability and strength: the probable ones, or all with their evidence."""
    ranking = [item for item in found.diagnosis.ranking if item.effect]
    listed = [item for item in ranking if every or item.probability >= MIN_CHANCE_LISTED]
    if listed:
        yield f"  {'effect':{NAME_WIDTH}}" + ("evidence  " if every else "") + "chance   strength"
    for item in listed:
        evidence = f"{item.log_bayes:+8.1f}  " if every else ""
        strength = strength_in_words(*item.best.strength(), item.best.unit, system)
        yield from candidate_row(
            str(item.best.candidate.place), f"{evidence}{percent(item.probability):>6}   {strength}"
        )
    if rest := len(ranking) - len(listed):
        yield f"  {counted(rest, 'effect')} with a chance below {MIN_CHANCE_LISTED:.0%}; --details lists all"


def candidate_row(name: str, figures: str) -> Iterator[str]:
    """A row of the table of effects; a name longer than its column has a line of its own."""
    if len(name) > NAME_WIDTH:
        yield f"  {name}"
        name = ""
    yield f"  {name:{NAME_WIDTH}}{figures}"


def misses_drawn(found: Findings, system: str = "SI") -> Iterator[str]:
    """The absolute errors of the latest flights as bars, before and after; empty if nothing is missing or forecasts use
    the plain model."""
    if found.diagnosis.effect == "none" or all(not places for _, places in found.diagnosis.averaged):
        return
    most, before, after = miss_bars(found, MAX_DRAWN)
    yield f"  misses, flight by flight (highest bar {ShownUnits(system).length(most)}):"
    yield f"    {'before':6} {before}"
    yield f"    {'after':6} {after}"
    yield ""


def miss_bars(found: Findings, count: int) -> tuple[float, str, str]:
    """The absolute errors of the last `count` flights as bars, before and after, and the largest error. [m]"""
    rows = [row for row in misses(found) if row["before_m"] is not None][-count:]
    most = max(abs(row[when]) for row in rows for when in ("before_m", "after_m"))
    heights = [[abs(row[when]) / most for row in rows] for when in ("before_m", "after_m")]
    before, after = ("".join(BARS[min(int(one * len(BARS)), len(BARS) - 1)] for one in some) for some in heights)
    return most, before, after


def misses(found: Findings) -> list[dict[str, Any]]:
    """Flown minus leave-one-out forecast of each apogee, before and after; None for a flight that is not used. [m]"""
    diagnosis = found.diagnosis
    truth, seen = np.exp(diagnosis.data.values[:, 0]), diagnosis.data.seen[:, 0]
    before, after = diagnosis.forecasts_before.apogee, diagnosis.forecasts_after.apogee
    return [
        {
            "flight_id": flight.flight_id,
            "before_m": float(truth[row] - before[row]) if seen[row] else None,
            "after_m": float(truth[row] - after[row]) if seen[row] else None,
        }
        for row, flight in enumerate(diagnosis.model.flights)
    ]


def _residual(found: Findings, shown: ShownUnits) -> Iterator[str]:
    before = found.left_out.before.score
    count = found.left_out.before.flights
    yield f"  {counted(count, 'flight')}, each forecast from the others without a correction:"
    yield (
        f"  mean error {shown.length(before.mae, 1)}, bias {shown.difference(before.bias)}, "
        f"{before.coverage90:.0%} of flights in the 90% interval"
    )
    significant = [row for row in (*found.patterns, *found.readout_patterns) if row.p < MAX_P_SHOWN]
    for row in significant:
        yield f"  {misses_of(row.readout)} follow {column_in_words(row.against)} ({_p_value(row.p)})"
    for spread in found.spreads:
        if spread.autocorrelation_p < 0.05:
            yield (
                f"  {misses_of(spread.readout)} persist: correlation with the flight before "
                f"{spread.autocorrelation:+.2f} ({_p_value(spread.autocorrelation_p)})"
            )
    if significant:
        yield "  p is corrected for the number of columns tested."
    else:
        yield "  Misses follow no recorded column."


def _p_value(p: float) -> str:
    """A p-value in parentheses: `p 0.03`, `p < 0.01`."""
    return "p < 0.01" if p < 0.01 else f"p {p:.2f}"


def beside_verdict(found: Findings, system: str = "SI") -> Iterator[str]:
    """Details of a verdict: its effect on the next flight, its probability, the most informative experiment, the
    consequences of accepting it, and the evidence of the logs; in the units of a system."""
    diagnosis = found.diagnosis
    if found.unexplained is not None:
        yield found.unexplained.words(system)
    yield in_next_flight(found.next_flight, system)
    yield how_sure(found)
    if diagnosis.fits.left:
        left = diagnosis.fits.pattern
        yield f"the model does not fit all that was measured: {left} ({_p_value(diagnosis.fits.p).strip('()')})"
    if diagnosis.also:
        yield f"these flights cannot distinguish it from: {', '.join(diagnosis.also)}"
    for number, test in enumerate(found.tests):
        yield f"  {'to decide: ' if not number else 'or '}{test.words(system)}"
    yield from what_accepting_changes(found)
    yield from climbs(found)


def climbs(found: Findings) -> Iterator[str]:
    """What the logs of the flights show of drag and thrust."""
    yield from forces_in_words(found.diagnosis.forces)


def in_next_flight(one: RepeatedFlight, system: str = "SI") -> str:
    """The forecast, and its change: `next F24 in the same conditions: 281 m, ...; 5 m (1.7%) lower than with the plain
    model`."""
    change, shown = one.after - one.before, ShownUnits(system)
    span = f"{shown.length(one.after)}, 90% interval {shown.lengths(*one.interval)}"
    forecast = f"next {one.flight.motor} in the same conditions: {span}"
    if abs(change) < 0.5:
        return f"{forecast}; the same as without a correction"
    direction = "higher" if change > 0 else "lower"
    size = f"{shown.length(abs(change))} ({abs(change) / one.before:.1%})"
    return f"{forecast}; {size} {direction} than without a correction"


def how_sure(found: Findings) -> str:
    """How probable the verdict is, in percent and in odds; and how much of it is something that the loop does not try,
    so that the rest is what forecasts average over."""
    diagnosis = found.diagnosis
    sure, posterior = diagnosis.confidence, diagnosis.posterior
    if not diagnosis.accepted:
        missing = 1 - sure if diagnosis.effect == "none" else sure
        tried, other = _split(missing, 1 - posterior.nothing)
        parts = f": {tried} an effect or pattern that the loop tries, {other} anything else" if other else ""
        return f"chance that something is missing: {percent(missing)}{parts}"
    group = diagnosis.also and len(diagnosis.accepted) == 1 and sure > _alone(found)
    names = [trial.candidate.effect for trial in diagnosis.accepted]
    listed = posterior.any_of([*names, *diagnosis.also]) if group else posterior.all_of(names)
    _, other = _split(listed, sure)
    beside = f", and {other} that something else is missing, too" if other else ""
    return (
        f"chance that {'it is one of these' if group else 'this is right'}: {percent(sure)} ({in_odds(sure)}){beside}"
    )


def _split(whole: float, part: float) -> tuple[str, str]:
    """A part of a probability and the rest [1], which add up as shown; the rest is empty below one percent."""
    rest = round(100 * whole) - round(100 * part)
    return percent(part), f"{rest}%" if rest >= 1 else ""


def _alone(found: Findings) -> float:
    """Probability of the effect in the verdict, with a margin for rounding. [1]"""
    return found.diagnosis.posterior.inclusion.get(found.diagnosis.effect, 0.0) + 1e-9


def in_odds(chance: float) -> str:
    """A probability [1] as odds: `9 to 1 on`, `2 to 1 against`."""
    odds = min(max(chance, 1 - chance) / max(min(chance, 1 - chance), 1e-9), 1e9)
    text = "more than 999" if odds > 999 else f"{odds:.1f}" if odds < 3 else f"{odds:.0f}"
    return f"{text} to 1 {'on' if chance >= 0.5 else 'against'}"


def what_forecasts_become(found: Findings) -> str:
    """The sets that forecasts average over after the verdict is accepted."""
    averaged = found.diagnosis.averaged
    if all(not places for _, places in averaged):
        worse = found.diagnosis.posterior.nothing < MATCH_PROBABILITY and not found.diagnosis.accepted
        return f"forecasts use no correction{NOT_BETTER if worse else ''}"
    rare = 0.0 if _is_certain(found) else left_out_of_average(found.diagnosis.posterior)
    chances: defaultdict[str, float] = defaultdict(float)
    for chance, places in averaged:
        names = dict.fromkeys(_at_any_time(place) for place in places)
        chances[" and ".join(names) or "no correction"] += chance * (1 - rare)
    parts = [f"{chance:.0%} {name}" for name, chance in sorted(chances.items(), key=lambda one: -one[1])]
    rest = 100 - sum(round(100 * chance) for chance in chances.values())  # so that what is shown adds up
    others = ""
    if rare >= 0.01 and rest > 0:
        others = f"; sets below {MIN_AVERAGED:.0%}, {rest}% in all, are left out and the others scaled up"
    return f"forecasts average over: {', '.join(parts)}{others}"


def _is_certain(found: Findings) -> bool:
    """Whether forecasts use the named effects in every set, as they do if a flyer named them."""
    names = set(found.diagnosis.effect.split("+"))
    return all(names <= {spoken(place.effect) for place in places} for _, places in found.diagnosis.averaged)


def _at_any_time(place: Place) -> str:
    """An effect and its motor or site, without its first flight."""
    return replace(place, since="").in_words if place.effect else "a pattern that no effect explains"


def what_accepting_changes(found: Findings) -> Iterator[str]:
    """The consequences of accepting, and how to choose otherwise."""
    averaged = found.diagnosis.averaged
    yield what_forecasts_become(found)
    if found.diagnosis.accepted and any(places for _, places in averaged):
        name = found.diagnosis.effect
        yield (
            f"--decline {name} excludes it"
            if _is_certain(found)
            else (f"--effect {name} treats it as certain, --decline {name} excludes it")
        )


def _errors(found: Findings, shown: ShownUnits) -> Iterator[str]:
    """Leave-one-out and forward-in-time errors, before and after, with their intervals."""
    yield f"  {'held-out error':24}{'MAE':>5} {f'[{shown.length_unit}]':14}{'RMSE':>6}{'bias':>6} {'':14}{'in 90%':>6}"
    for title, compared in (("left out", found.left_out), ("forward in time", found.forward)):
        if not compared.before.flights:
            continue
        rows = [("before", compared.before)] + [("after", compared.after)] * (found.diagnosis.effect != "none")
        for when, judged in rows:
            score = judged.score
            mae, low, high, rmse = (shown.length(one, 1).split()[0] for one in (score.mae, *judged.mae, score.rmse))
            bias = shown.difference(score.bias).split()[0]
            least, most = (shown.difference(one, 0).split()[0] for one in judged.bias)
            yield (
                f"  {title + ', ' + when:24}{mae:>5} {f'({low} to {high})':14}"
                f"{rmse:>6}{bias:>6} {f'({least} to {most})':14}{score.coverage90:6.0%}"
            )
    yield f"  left out: {found.left_out.how}"
    yield f"  forward in time: {found.forward.how}"
    yield "  in parentheses: 90% bootstrap intervals over flights"


def _signed(figure: float) -> str:
    """A figure in a column of nine characters, a dash if it is undefined because residuals are equal or too few."""
    return f"{figure:+9.2f}" if isfinite(figure) else f"{'-':>9}"


def _fingerprints(found: Findings) -> Iterator[str]:
    """Residuals of the readouts in units of expected scatter, and the fingerprints of the most likely effects."""
    short = {
        "top_speed": "speed",
        "burn_time": "burn",
        "peak_accel": "peak",
        "coast_to_apogee": "coast",
        "apogee_to_eject": "eject s",
        "coast_drag": "drag",
        "burn_impulse": "impulse",
    }
    names = [row.readout for row in found.spreads]
    yield f"  {'miss / expected scatter':24}" + "".join(f"{short.get(n, n.replace('_', ' ')[:8]):>9}" for n in names)
    yield f"  {'mean':24}" + "".join(_signed(row.bias) for row in found.spreads)
    yield f"  {'with the flight before':24}" + "".join(_signed(row.autocorrelation) for row in found.spreads)
    for trial, row in found.fingerprints:
        marks = {mark.readout: mark for mark in row}
        yield f"  {trial.candidate.effect + ' predicts':24}" + "".join(_signed(marks[n].expected) for n in names)
        yield f"  {'  observed':24}" + "".join(_signed(marks[n].found) for n in names)


def mean_misses(found: Findings, shown: ShownUnits) -> Iterator[str]:
    """The mean absolute errors of held-out flights, before and after; without a verdict what was looked for, and how
    good the plain model is."""
    if found.diagnosis.effect == "none":
        yield from _plain_model(found, shown)
        return
    for source, compared in _held_out(found):
        before, after = (shown.length(one.score.mae, 1) for one in (compared.before, compared.after))
        yield f"  mean miss {before}, {after} with the verdict; each flight forecast from {source}"


def _held_out(found: Findings) -> Iterator[tuple[str, Compared]]:
    """The errors of held-out flights, with what each was forecast from."""
    both = (("the others", found.left_out), ("earlier ones", found.forward))
    yield from (one for one in both if one[1].before.flights)


def _plain_model(found: Findings, shown: ShownUnits) -> Iterator[str]:
    """The effects that were looked for, and the errors of the plain model."""
    titles = {name: effect.title for name, effect in effects().items()}
    looked_for = dict.fromkeys(titles.get(item.effect, item.effect) for item in found.diagnosis.ranking if item.effect)
    yield f"  looked for: {', '.join(looked_for)}"
    apogee = float(np.nanmean(np.exp(found.diagnosis.data.values[:, 0])[found.diagnosis.data.seen[:, 0]]))
    for source, compared in _held_out(found):
        score, count = compared.before.score, compared.before.flights
        inside = f"{round(score.coverage90 * count)} of {count} inside the 90% interval"
        miss = f"{shown.length(score.mae, 1)} off on average ({score.mae / apogee:.0%})"
        yield f"  without a correction: {miss}, {inside}; each flight forecast from {source}"


def forces_in_words(forces: LoggedForces | None) -> Iterator[str]:
    """Which flights' drag switched, when and by how much; empty if no flight has a log."""
    if forces is None:
        return
    if forces.drag:
        yield f"drag along the coast, {counted(len(forces.drag), 'log')}: {_switched(forces)}"
    reasons: dict[str, list[str]] = {}
    for flight_id, why in forces.silent.items():
        reasons.setdefault(why, []).append(flight_id)
    for why, ids in reasons.items():
        others = f" and {len(ids) - 1} more" if len(ids) > 1 else ""
        yield f"{counted(len(ids), 'log')} without forces, {ids[0]}{others}: {why}"


def _switched(forces: LoggedForces) -> str:
    likely = {name: [step for step in one.steps if step.probability > 0.5] for name, one in forces.drag.items()}
    named = [f"{flight_label(name)} {', '.join(map(_step, steps))}" for name, steps in likely.items() if steps]
    return "it switches in " + "; ".join(named) if named else "constant within the errors"


def _step(step: DragStep) -> str:
    until = "on" if step.end is None else f"to {step.end:.1f} s"
    return f"from {step.begin:.1f} s {until} (times {with_sd(step.ratio, step.sd)})"
