"""The findings of the loop in words and figures: the verdict, residuals against a column, fingerprints."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from textual.content import Content

from fieldkit.flight import BY_NAME
from fieldkit.ledger import Version
from fieldkit.physics.effect import effects
from fieldkit.presentation.condition_axis import in_units
from fieldkit.presentation.loop_headline import headline
from fieldkit.presentation.loop_text import climbs, how_sure, in_next_flight, miss_bars, what_forecasts_become
from fieldkit.quantities import counted, in_system, measure, strength_in_words
from fieldkit.safe_text import printable
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.residual import columns_of, kinds_of, residuals
from fieldkit.services.findings import Compared, Findings
from fieldkit.services.model_versions import version_summary
from fieldkit.tui.loop.loop_look import PLAIN_MODEL
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.plots import round_ticks

MAX_BARS = 60
"""Number of latest flights whose errors are drawn: a row of 80 columns has room for them. [1]"""
EVEN_LOG_BAYES_FACTOR = 0.5
"""Below this log Bayes factor the evidence counts as even. [nat]"""


def verdict(found: Findings, system: str) -> Content:
    """The verdict as in `fieldkit loop`: what is missing, its effect on the next flight, the evidence, its probability,
    the test that would decide, the consequences of accepting it, and the errors on held-out flights."""
    diagnosis = found.diagnosis
    named = diagnosis.effect != "none"
    parts: cards.Styled = [
        (f"Verdict: {diagnosis.effect}" if named else "Verdict: no effect is named", "b $primary"),
        "\n",
        printable(in_system(diagnosis.why, system) if named else headline(found, system).sentence),
        "\n",
    ]
    for title, lines in _sections(found, system):
        shown = [_colored(f"{printable(line)}\n") for line in lines]
        parts += [(f"\n{title}\n", "b $primary"), *shown] if shown else []
    parts += [f"{printable(line)}\n" for line in found.excluded]
    parts += [("\nError on held-out flights\n", "b $primary")]
    for title, compared in (("each from all others", found.left_out), ("each from earlier ones", found.forward)):
        parts += [f"{line}\n" for line in _errors(title, compared, system)]
    return Content.assemble(*parts)


def _sections(found: Findings, system: str) -> Iterable[tuple[str, list[str]]]:
    """Parts of a verdict with titles, besides its name and its errors."""
    diagnosis = found.diagnosis
    leftover = [found.unexplained.words(system)] if found.unexplained is not None else []
    yield "Effect on the next flight", [*leftover, in_next_flight(found.next_flight, system)]
    if diagnosis.effect != "none":
        yield "Why: misses, flight by flight", _bars(found, system)
    also = [f"these flights cannot distinguish it from: {', '.join(diagnosis.also)}"] if diagnosis.also else []
    yield "How sure", [how_sure(found), *also, *climbs(found)]
    yield "What would decide", [f"{test.words(system)} (odds {test.odds})" for test in found.tests]
    yield "What accepting changes", [what_forecasts_become(found)]


def _colored(line: str) -> str | tuple[str, str]:
    """Bars of misses before and after in the colors of the headline."""
    color = {"before ": "$accent", "after  ": "$success"}.get(line[:7])
    return line if color is None else (line, color)


def _bars(found: Findings, system: str) -> list[str]:
    """The errors of the latest flights, before and after."""
    most, before, after = miss_bars(found, MAX_BARS)
    highest = measure(cards.APOGEE, most, system)
    return [f"before  {before}", f"after   {after}", f"the highest bar is {highest}"]


def _errors(title: str, compared: Compared, system: str) -> Iterable[str]:
    """Mean error before and after with its interval, and the fraction of flights inside their 90% intervals."""
    if not compared.before.flights:
        return
    yield f"{title}, {counted(compared.before.flights, 'flight')}"
    for when, judged in (("before", compared.before), ("after", compared.after)):
        mean = measure(cards.APOGEE, judged.score.mae, system)
        low, high = (measure(cards.APOGEE, one, system) for one in judged.mae)
        yield f"  {when:7}{mean:>9}  ({low} to {high})  {judged.score.coverage90:.0%} in 90%"


def residual_points(found: Findings, turn: int, system: str = "SI") -> tuple[str, list[tuple[float, float]], list[str]]:
    """Residuals against the column with the `turn`-th strongest correlation: its title, the points, and labels of the
    axis if the column is not numeric."""
    diagnosis = found.diagnosis
    off = residuals(diagnosis)
    numbers, kinds = columns_of(diagnosis), kinds_of(diagnosis)
    usable = [n for n, v in numbers.items() if (np.isfinite(v) & np.isfinite(off)).sum() > 1]
    usable += [name for name, group in kinds.items() if len(set(group)) > 1]
    order = {row.against: place for place, row in enumerate(found.patterns)}
    usable.sort(key=lambda name: order.get(name, len(order)))
    name = usable[turn % len(usable)]
    pattern = next((row for row in found.patterns if row.against == name), None)
    tested = "too few values to test"
    if pattern is not None:
        seen = "they correlate" if pattern.p < PATTERN_P_VALUE else "no pattern"
        tested = f"{seen}, p {pattern.p:.2f}"
    ticks = [] if name in numbers else list(dict.fromkeys(kinds[name]))
    title, places = in_units(name, numbers[name], system) if name in numbers else (name, None)
    if places is None:
        places = np.array([float(ticks.index(kind)) for kind in kinds[name]])
    points = [(float(x), float(y)) for x, y in zip(places, off, strict=True) if np.isfinite(x + y)]
    return f"residual / expected scatter, vs. {title}: {tested}", points, ticks


def fingerprint(found: Findings, turn: int, width: int) -> Content:
    """The fingerprints of the residual and of an effect, with bars as long as a width allows. [cell]"""
    if not found.fingerprints:
        return Content("no effect to compare with")
    trial, marks = found.fingerprints[turn % len(found.fingerprints)]
    largest = max((abs(x) for mark in marks for x in (mark.expected, mark.found) if x == x), default=1.0)
    name = 20
    cells = max(1, min(LONGEST_BAR, (width - name - 2 * FIGURE_CELLS - len(" similar")) // 4))
    wide = FIGURE_CELLS + 2 * cells
    parts: cards.Styled = [(printable(trial.candidate.place.in_words), "b $primary")]
    parts.append(f"\n{'in expected scatter':{name}}{'predicted':^{wide}}{'observed':^{wide}}")
    for mark in marks:
        title = BY_NAME[mark.readout].title
        if mark.found != mark.found:
            parts.append(f"\n{title:{name}}{'not recorded':^{2 * wide}}")
            continue
        similar = "similar" if abs(mark.expected - mark.found) < 2 * mark.sd else "differs"
        bars = (_signed_bar(figure, largest, cells) for figure in (mark.expected, mark.found))
        parts.append(f"\n{title:{name}}{''.join(bars)} {similar}")
    return Content.assemble(*parts)


def ranking_rows(diagnosis: Diagnosis, system: str) -> dict[str, tuple[str, ...]]:
    """Effects with their places, the most probable first: description, probability, evidence, and strength in the units
    of a system."""
    rows: dict[str, tuple[str, ...]] = {}
    for item in diagnosis.ranking:
        if item.effect:
            mean, sd = item.best.strength()
            place = item.best.candidate.place
            words = strength_in_words(mean, sd, item.best.unit, system).split()
            strength = words[: 3 if "%" in words[2] else 4]  # with its unit, without what it is a fraction of
            rows[str(place)] = (place.in_words, f"{item.probability:.0%}", f"{item.log_bayes:+.1f}", " ".join(strength))
    return rows


def effect_at_length(diagnosis: Diagnosis, row: str, system: str) -> Content:
    """Details of a row of the ranking: the effect, its strength, its evidence, and the test that would distinguish
    it, in the units of a system."""
    item = next(one for one in diagnosis.ranking if one.effect and str(one.best.candidate.place) == row)
    place, (mean, sd) = item.best.candidate.place, item.best.strength()
    effect = effects().get(place.effect)
    words = place.in_words
    parts: cards.Styled = [(printable(words), "b $primary"), "" if words == row else f"  ({printable(row)})"]
    parts.append(f"\n{effect.explains[:1].upper()}{effect.explains[1:]}." if effect is not None else "")
    parts.append(f"\nstrength  {strength_in_words(mean, sd, item.best.unit, system)}")
    parts.append(f"\nevidence  {item.log_bayes:+.1f}: {_odds(item.log_bayes)}")
    parts.append(f"\ntest     {effect.tell_apart}" if effect is not None else "")
    return Content.assemble(*parts)


def _odds(log_bayes: float) -> str:
    """A log Bayes factor as odds: `20 to 1 for it`."""
    if abs(log_bayes) < EVEN_LOG_BAYES_FACTOR:
        return "these flights favor neither"
    odds = math.exp(min(abs(log_bayes), 20.0))
    odds_text = "more than 1000" if odds > 1000 else f"{odds:.2g}" if odds < 10 else f"{odds:.0f}"
    return f"{odds_text} to 1 {'for' if log_bayes > 0 else 'against'} it"


def version_rows(versions: Sequence[Version], system: str) -> dict[int, tuple[str, ...]]:
    """Models by number, the plain one first: number, date, added effects, errors, and which is in use."""
    used = any(version.active for version in versions)
    rows: dict[int, tuple[str, ...]] = {PLAIN_MODEL: ("0", "", "plain", "", "" if used else "in use ✓")}
    return rows | {version.number: _version(version, system) for version in versions}


def _version(version: Version, system: str) -> tuple[str, ...]:
    """A row: number, date, the effects that a model added, the errors before and after, and whether it is in use."""
    adds, *errors = version_summary(version)
    shown = ["?" if error is None else measure(cards.APOGEE, error, system) for error in errors]
    made, mark = f"{version.at:%Y-%m-%d}", "in use ✓" if version.active else ""
    return (str(version.number), made, printable(adds), " → ".join(shown), mark)


def draw_points(points: Sequence[tuple[float, float]], ticks: Sequence[str], plt: Any, ink: Any) -> None:
    """Draw points around the line of zero error."""
    across, up = zip(*points, strict=True)
    plt.scatter(across, up, marker="●", color=ink.mark)
    plt.hline(0.0, color=ink.line)
    low, high = min(math.floor(min(up)), -1), max(math.ceil(max(up)), 1)
    step = math.ceil((high - low) * LINES_PER_TICK / max(ink.height - FRAME_LINES, 1))
    plt.yticks([tick for tick in range(low, high + 1) if tick % step == 0])
    plt.ylim(low - 0.4, high + 0.4)  # a label in the last row would collide with those below it
    if ticks:
        plt.xticks(list(range(len(ticks))), [printable(tick) for tick in ticks])
        plt.xlim(-0.5, len(ticks) - 0.5)
        return
    whole = all(float(x).is_integer() for x in across)
    at = [one for one in round_ticks(min(across), max(across), TICKS) if one.is_integer() or not whole]
    plt.xticks(at, [f"{one:g}" for one in at])


PATTERN_P_VALUE = 0.05
"""A corrected p-value below which a pattern is reported. [1]"""
LINES_PER_TICK = 1.5
"""Minimum distance of two labels beside an axis; of two on one line, plotext drops one at random. [cell]"""
LONGEST_BAR, FIGURE_CELLS = 5, 9
"""Longest bar to either side of zero, and the figure beside it with its spaces and the zero. [cell]"""
FRAME_LINES = 4
"""Lines of a plot above and below its points: a frame, and labels. [cell]"""
TICKS = 7
"""Maximum number of labels below an axis of numbers. [1]"""


def _signed_bar(value: float, largest: float, most: int) -> str:
    """A figure with a bar to the left or right of zero, up to a width in cells."""
    cells = round(abs(value) / (largest or 1.0) * most)
    left = ("█" * cells).rjust(most) if value < 0 else " " * most
    right = ("█" * cells).ljust(most) if value >= 0 else " " * most
    return f"{value:+6.2f} {left}│{right} "
