"""What the loop found, in words and figures: the verdict, residuals against a column, fingerprints side by side."""

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from textual.content import Content

from fieldkit.flight import BY_NAME
from fieldkit.measures import measure
from fieldkit.safe_text import printable
from fieldkit.tui import cards

if TYPE_CHECKING:
    from fieldkit.ledger import Version
    from fieldkit.loop.diagnose import Diagnosis
    from fieldkit.loop.findings import Compared, Findings

PLAIN = 0
"""The number of the model without anything added."""
Parts = list[str | tuple[str, str]]


def verdict(found: "Findings", system: str) -> Content:
    """What is missing, how sure that is, and the error on flights not seen, before and after."""
    from fieldkit.loop.force.words import climbs_in_words

    diagnosis = found.diagnosis
    parts: Parts = [(f"Verdict: {diagnosis.effect}", "b $primary"), "\n", printable(diagnosis.why), "\n"]
    if found.unexplained is not None:
        parts.append(
            printable(f"{found.unexplained.in_words}; intervals {found.unexplained.widened:.2f} times as wide\n")
        )
    parts.append(_chance(found))
    if diagnosis.also:
        parts.append(f"these flights cannot tell it from: {', '.join(diagnosis.also)}\n")
        parts += [f"  to tell: {printable(test.in_words)}\n" for test in found.tests]
    parts += [f"{printable(line)}\n" for line in climbs_in_words(found.testimony)]
    parts += [("\nError of the forecast on flights not seen\n", "b $primary")]
    for title, compared in (("each from all others", found.left_out), ("each from earlier ones", found.forward)):
        parts += [f"{line}\n" for line in _errors(title, compared, system)]
    if diagnosis.accepted or found.unexplained is not None:
        parts.append(("\na accepts it, d leaves the model as it is", "b"))
    return Content.assemble(*parts)


def _chance(found: "Findings") -> str:
    """How sure the verdict is."""
    effect, confidence = found.diagnosis.effect, found.diagnosis.confidence
    if effect == "none":
        return f"chance that something is missing: {1 - confidence:.0%}, before the test on unseen flights\n"
    return f"chance that {'something is missing' if effect == 'unexplained' else 'it is this'}: {confidence:.0%}\n"


def _errors(title: str, compared: "Compared", system: str) -> Iterable[str]:
    """Mean error before and after, with its interval, and how many flights the intervals held."""
    if not compared.before.flights:
        return
    yield f"{title}, {compared.before.flights} flights"
    for when, judged in (("before", compared.before), ("after", compared.after)):
        mean = measure(cards.APOGEE, judged.score.mae, system)
        low, high = (measure(cards.APOGEE, one, system) for one in judged.mae)
        yield f"  {when:7}{mean:>9}  ({low} to {high})  {judged.score.coverage90:.0%} in 90 %"


def residual_points(found: "Findings", turn: int) -> tuple[str, list[tuple[float, float]], list[str]]:
    """Residuals against a column, the `turn`-th by how much they hang together: what is said of it, the points, and
    the names along the axis where the column holds no numbers."""
    import numpy as np

    from fieldkit.loop.residual import columns_of, kinds_of, residuals

    diagnosis = found.diagnosis
    off = residuals(diagnosis)
    numbers, kinds = columns_of(diagnosis), kinds_of(diagnosis)
    usable = [n for n, v in numbers.items() if (np.isfinite(v) & np.isfinite(off)).sum() > 1]
    usable += [name for name, group in kinds.items() if len(set(group)) > 1]
    order = {row.against: place for place, row in enumerate(found.patterns)}
    usable.sort(key=lambda name: order.get(name, len(order)))
    name = usable[turn % len(usable)]
    pattern = next((row for row in found.patterns if row.against == name), None)
    tested = f"statistic {pattern.statistic:+.2f}, p {pattern.p:.2f} corrected" if pattern else "too few values to test"
    ticks = [] if name in numbers else list(dict.fromkeys(kinds[name]))
    places = numbers[name] if name in numbers else [float(ticks.index(kind)) for kind in kinds[name]]
    points = [(float(x), float(y)) for x, y in zip(places, off, strict=True) if np.isfinite(x + y)]
    return f"residual / expected scatter, against {name.replace('_', ' ')}: {tested}", points, ticks


def fingerprint(found: "Findings", turn: int) -> Content:
    """The fingerprint of the residual beside that of an effect."""
    if not found.fingerprints:
        return Content("no effect to compare with")
    trial, marks = found.fingerprints[turn % len(found.fingerprints)]
    largest = max((abs(x) for mark in marks for x in (mark.expected, mark.found) if x == x), default=1.0)
    parts: Parts = [(printable(str(trial.candidate.place)), "b $primary")]
    parts.append(f"\n{'in expected scatter':22}{'it would leave':^19}{'there was':^19}")
    for mark in marks:
        title = BY_NAME[mark.readout].title
        if mark.found != mark.found:
            parts.append(f"\n{title:22}{'not recorded':^38}")
            continue
        alike = "alike" if abs(mark.expected - mark.found) < 2 * mark.sd else "differs"
        parts.append(f"\n{title:22}{_lean(mark.expected, largest)}{_lean(mark.found, largest)} {alike}")
    return Content.assemble(*parts)


def ranking_rows(diagnosis: "Diagnosis") -> dict[str, tuple[str, ...]]:
    """Effects by where they would act, best first: the place, the evidence, the strength."""
    rows: dict[str, tuple[str, ...]] = {}
    for item in diagnosis.ranking:
        if item.effect:
            mean, sd = item.best.strength()
            place = str(item.best.candidate.place)
            rows[place] = (place, f"{item.log_bayes:+.1f}", f"{mean:.3g} ± {sd:.2g} {item.best.unit}")
    return rows


def version_rows(versions: "Sequence[Version]", system: str) -> dict[int, tuple[str, ...]]:
    """Models by their number, the plain one first: when it was made, what it added, and which is in use."""
    used = any(version.active for version in versions)
    rows: dict[int, tuple[str, ...]] = {PLAIN: ("0", "", "plain", "", "" if used else "in use ✓")}
    return rows | {version.number: _version(version, system) for version in versions}


def _version(version: "Version", system: str) -> tuple[str, ...]:
    """A row: what a model added, and the error before and after."""
    from fieldkit.loop.desk import version_adds

    payload = version.payload
    errors = [measure(cards.APOGEE, payload[when]["mae_m"], system) for when in ("before", "after")]
    made, mark = f"{version.at:%Y-%m-%d}", "in use ✓" if version.active else ""
    return (str(version.number), made, version_adds(payload), " → ".join(errors), mark)


def draw_points(points: Sequence[tuple[float, float]], ticks: Sequence[str], plt: Any, ink: Any) -> None:
    """Points about a line of no error."""
    across, up = zip(*points, strict=True)
    plt.scatter(across, up, marker="●", color=ink.mark)
    plt.hline(0.0, color=ink.line)
    low, high = min(math.floor(min(up)), -1), max(math.ceil(max(up)), 1)
    plt.yticks(list(range(low, high + 1)))
    plt.ylim(low - 0.4, high + 0.4)  # a label in the last row would run into those below it
    if ticks:
        plt.xticks(list(range(len(ticks))), [printable(tick) for tick in ticks])
        plt.xlim(-0.5, len(ticks) - 0.5)
    elif all(float(x).is_integer() for x in across):
        first, last = int(min(across)), int(max(across))
        plt.xticks(list(range(first, last + 1, max(1, math.ceil((last - first) / TICKS)))))


TICKS = 6
"""Labels below an axis of whole numbers, at most but one. [1]"""


def _lean(value: float, largest: float) -> str:
    """A figure with a bar to the left or the right of zero, 19 cells wide."""
    cells = round(abs(value) / (largest or 1.0) * 5)
    left = ("█" * cells).rjust(5) if value < 0 else " " * 5
    right = ("█" * cells).ljust(5) if value >= 0 else " " * 5
    return f"{value:+6.2f} {left}│{right} "
