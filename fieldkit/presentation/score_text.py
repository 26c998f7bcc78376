"""How forecasts fared, in lines: errors beside the rivals', whether the bar is beaten, where flights lay."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from fieldkit.forecast.evaluation.forward_in_time import tally
from fieldkit.forecast.evaluation.rivals import BAR

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.rivals import Report
    from fieldkit.scoring.proper_scores import Calibration

LONGEST = 30
"""Of a bar. [letters]"""


def errors(found: "Report") -> Iterator[str]:
    """What each way of forecasting missed by, and the share of flights in the intervals."""
    ways, inside = tally(found.rows)
    for way in ways:
        yield (
            f"{way.name}: {way.median_share:.1%} in the median of {way.flights}, {way.mean_share:.1%} in the mean, "
            f"{way.mae:.1f} m"
        )
    yield f"{inside:.0%} in the 90 % interval; CRPS {found.crps:.1f} m"


def against_the_bar(found: "Report") -> Iterator[str]:
    """Whether the scalar correction is beaten, and the rockets where it is not."""
    for one in found.against:
        if one.rival == BAR:
            words = {
                "better": "The scalar correction is beaten",
                "worse": "The scalar correction is BETTER than fieldkit",
                "unclear": "Whether the scalar correction is beaten, these flights cannot tell",
            }
            yield f"{words[one.verdict]}: mean error {one.error:.1%} against {one.theirs:.1%} on {one.flights} flights."
    for rocket, one in found.behind:
        yield (
            f"Not beaten on {rocket or 'no rocket'}: {one.error:.1%} against {one.theirs:.1%} on {one.flights} flights"
            f"{', which may be chance' if one.verdict != 'worse' else ''}."
        )


def histogram(found: "Calibration") -> Iterator[str]:
    """PITs as bars that should be as long as each other, and the share of flights in each interval."""
    low, high = found.expected
    count = sum(found.counts)
    yield f"where flights lay in their forecasts (even is right; chance leaves {low:.0f} to {high:.0f} in each)"
    longest = max(*found.counts, 1)
    for place, number in enumerate(found.counts):
        bar = "█" * round(LONGEST * number / longest)
        note = "" if low <= number <= high else "  too few" if number < low else "  too many"
        yield f"  {place * 10:3d}-{place * 10 + 10:3d} %  {bar} {number}{note}"
    for one in found.intervals:
        least, most = one.expected
        verdict = "as it should" if one.honest else "too narrow" if one.held < one.level else "too wide"
        yield f"  {one.level:.0%} interval: {one.held:.0%} of {count}, by chance {least:.0%} to {most:.0%}: {verdict}"
