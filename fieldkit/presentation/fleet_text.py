"""The loop over a fleet as JSON under the contract's keys, and as lines for a flyer."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from fieldkit.quantities import ShownUnits, counted, percent
from fieldkit.selection.fleet_groups import SharedDifference
from fieldkit.services.fleet_loop import FleetLoop, FleetResult

EVALUATION = (
    "later flights of the group, each forecast from all earlier flights: before as forecast then, "
    "after with the difference estimated from the earlier flights; the difference itself was found on all flights, "
    "so the error after is too low: by the whole gain if the group stands out by chance"
)
CHANGES: Mapping[str, tuple[str, str]] = {
    "thrust": ("less thrust and impulse than expected", "more thrust and impulse than expected"),
    "stretch": ("shorter burn", "longer burn"),
    "drag": ("less drag, as in thinner air", "more drag, as in denser air"),
    "apogee": ("lower heights than the flights explain", "higher heights than the flights explain"),
}
"""A negative and a positive change of each quantity in words."""


def fleet_document(found: FleetLoop) -> dict[str, Any]:
    """The findings under the contract's keys."""
    return {
        "n_rockets": found.rockets,
        "n_flights": found.flights,
        "findings": [_finding(one) for one in found.results],
        "rivals": [
            {"name": one.name, "n_flights": one.flights, "mae_m": one.mae, "crps_m": one.crps} for one in found.rivals
        ],
        "evaluation": EVALUATION,
    }


def _finding(result: FleetResult) -> dict[str, Any]:
    one = result.finding
    return {
        "effect": one.candidate.effect,
        "level": one.candidate.level,
        "of": one.candidate.of,
        "from_date": one.candidate.since.isoformat() if one.candidate.since else None,
        "rockets": list(result.rockets),
        "flights": [flight.flight_id for flight in result.flights],
        "probability": one.probability,
        "evidence": one.log_bayes,
        "parameters": {
            name: {"mean": mean, "sd": sd, "unit": "log ratio"} for name, (mean, sd) in one.strengths.items()
        },
        "before": result.before and {"n_flights": result.later, **result.before.json()},
        "after": result.after and {"n_flights": result.later, **result.after.json()},
        "why": in_words(result),
        "others": [
            {"effect": other.effect, "level": other.level, "of": other.of, "probability": chance}
            for other, chance in one.others
            if other.place != one.candidate.place
        ],
    }


def fleet_lines(found: FleetLoop, system: str = "SI") -> Iterator[str]:
    """The findings in sentences, most probable first, with the errors before and after, in the units of a system."""
    shown = ShownUnits(system)
    yield f"{counted(found.rockets, 'rocket')}, {counted(found.flights, 'normal flight')}"
    if not found.results:
        yield "  Nothing that several rockets share is missing from their model."
        return
    for result in found.results:
        yield ""
        yield f"  {in_words(result)}"
        yield f"  chance that this group differs: {percent(result.finding.probability)}"
        if result.before and result.after:
            before, after = (shown.length(errors.mae, 1) for errors in (result.before, result.after))
            count = counted(result.later, "later flight")
            yield f"  mean miss of its {count}: {before} as forecast, {after} with the difference;"
            chance = percent(1 - result.finding.probability)
            yield f"    it was found on them too: if it is chance ({chance}), so is the gain"
        for other, probability in result.finding.others:
            if other.place != result.finding.candidate.place and probability >= 0.05:
                yield f"  or else ({percent(probability)}): {_where(other)}"
    if found.rivals:
        yield ""
        yield "  mean miss of simple rules on the same flights:"
        for rival in found.rivals:
            yield f"    {rival.name:28}{shown.length(rival.mae, 1):>9}   {counted(rival.flights, 'flight')}"


def in_words(result: FleetResult) -> str:
    """A finding in a sentence: what differs, since when, by how much, on how many flights of how many rockets."""
    changes = " and ".join(_change(name, *strength) for name, strength in result.finding.strengths.items())
    count = f"{counted(len(result.flights), 'flight')} of {counted(len(result.rockets), 'rocket')}"
    return f"{_where(result.finding.candidate)}: {changes} ({count})"


def _where(one: SharedDifference) -> str:
    """The group of a candidate: `AeroTech F24W since 2025-09-01`, `flights at Mesa`."""
    before = {"day": "flights on ", "site": "flights at ", "device": "altimeter "}.get(one.level, "")
    since = f" since {one.since}" if one.since else ""
    return f"{before}{one.of}{since}"


def _change(quantity: str, mean: float, sd: float) -> str:
    """A change of a quantity in percent with its 90% interval: `24% less thrust and impulse than expected (20 to
    27%)`, or without a direction if the interval contains zero."""
    low, high = (100 * float(np.expm1(mean + side * 1.645 * sd)) for side in (-1, 1))
    if low < 0 < high:
        return f"{CHANGES[quantity][0]} or {CHANGES[quantity][1].split()[0]} ({low:+.0f} to {high:+.0f}%)"
    sizes = sorted((abs(low), abs(high)))
    size = abs(100 * float(np.expm1(mean)))
    return f"{size:.0f}% {CHANGES[quantity][int(mean > 0)]} ({sizes[0]:.0f} to {sizes[1]:.0f}%)"
