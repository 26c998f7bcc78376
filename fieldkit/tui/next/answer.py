"""An answer on the Decide screen: text, details and picture, and its main figure in large digits."""

from dataclasses import dataclass, replace
from typing import Any

from fieldkit.forecast.evaluation.comparison import ScoreReport
from fieldkit.planning.ballast import Ballast
from fieldkit.planning.delay import Delays
from fieldkit.planning.quantiles import three_of_all
from fieldkit.presentation.forecast_text import when_it_fires
from fieldkit.presentation.score_text import intervals_in_brief
from fieldkit.quantities import ShownUnits, counted
from fieldkit.shapes import Array, Float
from fieldkit.tui.next.intervals import Intervals


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer in lines with its details: its conditions and every safety check. `title` is that of its picture:
    intervals on one scale, or the plot by `draw`, with an optional `second` plot next to it; with both, a tall screen
    shows the plot under the title `below`. `large` is its main figure
    in large digits, with up to three lines `about` it."""

    words: tuple[str, ...]
    beside: tuple[str, ...] = ()
    title: str = ""
    intervals: Intervals | None = None
    below: str = ""
    draw: Any = None
    second: Any = None
    large: str = ""
    about: tuple[str, ...] = ()
    folded: tuple[str, ...] = ()
    """The details with only the failed safety checks, and how many others there are; empty if nothing is left out."""

    @property
    def text(self) -> str:
        """The whole answer as text, for copying."""
        return "\n".join([*self.words, *([""] if self.beside else []), *self.beside])


def with_delay(answer: Answer, judged: Delays) -> Answer:
    """The best delay; the answer is unchanged if there is none or it is not known when it fires."""
    best = judged.delays[0] if judged.delays else None
    if best is None or best.after_apogee is None:
        return answer
    about = (
        "s, the best delay" + ", drilled: plan it (p)" * (not best.on_sale),
        f"fires {when_it_fires(best.after_apogee[1])}",
        f"too fast in {best.too_fast:.0%} of cases",
    )
    return replace(answer, large=f"{best.delay:g}", about=about)


def with_ballast(answer: Answer, best: Ballast, system: str) -> Answer:
    """The dry mass to fly: the current one unless a change is clearly better."""
    shown = ShownUnits(system)
    large, unit = shown.mass(best.mass if best.clear else best.mass - best.add).split(" ", 1)
    change = f"{'add' if best.add >= 0 else 'remove'} {shown.mass(abs(best.add))}" if best.clear else "no change"
    result = best.there if best.clear else best.today
    return replace(answer, large=large, about=(f"{unit} dry mass", change, f"mean miss {shown.length(result.error)}"))


def with_points(answer: Answer, points: Float[Array, "draw"]) -> Answer:
    """The expected points of a flight."""
    low, _, high = three_of_all(points)
    about = ("points expected per flight", f"90% {low:.0f}-{high:.0f}", "fewer are better")
    return replace(answer, large=f"{points.mean():.0f}", about=about)


def with_misses(answer: Answer, found: ScoreReport, rocket: str, system: str) -> Answer:
    """The mean miss of forecasts of a rocket's flights, each from the earlier ones."""
    large, unit = ShownUnits(system).length(found.ways[0].mae).split(" ", 1)
    flights = f"{counted(len(found.rows), 'flight')} of {rocket}, each from the earlier ones"
    about = (f"{unit}, the mean miss of forecasts", flights, intervals_in_brief(found))
    return replace(answer, large=large, about=about)
