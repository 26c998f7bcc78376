"""A closed loop in one sentence of the flyer's terms, and the one thing to do next."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fieldkit.messages import message, of_unit
from fieldkit.physics.effect import effect_named
from fieldkit.quantities import ShownUnits, in_system, percent
from fieldkit.selection.candidates import EACH_GROUP
from fieldkit.selection.trial import Trial
from fieldkit.selection.verdict import MATCH_PROBABILITY
from fieldkit.services.findings import Findings

OF_MASS = "fraction of the dry mass"
"""The unit of strengths that a flyer reads as a mass."""
SURE_PROBABILITY = 0.9
"""Probability of a verdict from which its sentence is stated without it. [1]"""


@dataclass(frozen=True, slots=True)
class Headline:
    """One sentence, what else was found, the next step, and the mean miss of held-out flights before and after [m];
    `after` is None if accepting changes nothing."""

    sentence: str
    also: tuple[str, ...]
    step: str
    before: float
    after: float | None


def headline(found: Findings, system: str = "SI") -> Headline:
    """The findings of a loop, amounts in the units of a system."""
    diagnosis, compared = found.diagnosis, found.left_out
    changes = any(places for _, places in diagnosis.averaged)
    named = [sentence_of(found, trial, system) for trial in diagnosis.accepted]
    if not named:
        named = [_without_name(found, system)]
    elif diagnosis.confidence < SURE_PROBABILITY:
        named[0] = f"Probably ({percent(diagnosis.confidence)}): {named[0]}"
    return Headline(
        named[0],
        tuple(named[1:]),
        _step(found, system),
        compared.before.score.mae,
        compared.after.score.mae if changes else None,
    )


def sentence_of(found: Findings, trial: Trial, system: str) -> str:
    """An effect as a sentence with its amount: `Astra C is about 66 g lighter than entered.`"""
    place, mean = trial.candidate.place, trial.strength()[0]
    if place.pattern:
        return f"{found.rocket}: {place.in_words}."
    effect = effect_named(place.effect)
    where = place.where or found.rocket
    if effect.per == "config" and place.where:
        where = f"{found.rocket} {place.where}"
    since = f" from flight {place.since} on" if place.since else ""
    if effect.says is None or place.where == EACH_GROUP:
        what = effect.explains
        return f"{what[:1].upper()}{what[1:]}{since}."
    text = effect.says[int(mean > 0)].format(where=where, amount=_amount(found, trial, system))
    return f"{text[:1].upper()}{text[1:]}{since}."


def _amount(found: Findings, trial: Trial, system: str) -> str:
    """The size of a strength: a mass in grams or ounces, another fraction in percent."""
    size, unit = abs(trial.strength()[0]), trial.unit
    if unit == OF_MASS:
        where = trial.candidate.place.where
        flights = found.diagnosis.model.flights
        masses = [one.dry_mass for one in flights if one.dry_mass and where in ("", EACH_GROUP, one.config)]
        if masses:
            return ShownUnits(system).mass(size * float(np.mean(masses)))
    if unit.startswith("fraction "):
        return percent(size)
    return in_system(message(of_unit(float(f"{size:.2g}"), unit)), system)


def _without_name(found: Findings, system: str) -> str:
    """The sentence of a verdict that names no effect."""
    diagnosis = found.diagnosis
    if found.unexplained is not None and not found.unexplained.name:
        return f"{diagnosis.why[:1].upper()}{diagnosis.why[1:]}."
    if found.unexplained is not None:
        return f"No known effect explains that {found.unexplained.words(system)}."
    missing = 1 - diagnosis.confidence
    if missing >= 1 - MATCH_PROBABILITY:
        likely = next((item for item in diagnosis.ranking if item.effect), None)
        first = (
            f", most likely {likely.best.candidate.place.in_words} ({percent(likely.probability)})" if likely else ""
        )
        return f"Something may be missing ({percent(missing)}){first}, but these flights do not show what."
    return f"{found.rocket} flies as its model says: nothing is missing."


def _step(found: Findings, system: str) -> str:
    """The one thing to do next: what confirms the named effect, or else the flight that would decide."""
    diagnosis = found.diagnosis
    first = next((trial.candidate.place for trial in diagnosis.accepted if trial.candidate.place.effect), None)
    if first is not None:
        step = effect_named(first.effect).tell_apart
    elif found.tests:
        step = found.tests[0].words(system)
    elif diagnosis.effect == "none":
        step = "fly on; each flight narrows the forecast"
    else:
        step = "record what differed on these flights, such as wind, motor lot or changes of the rocket"
    return f"{step[:1].upper()}{step[1:]}."


def compared_bars(one: Headline, width: int, system: str) -> Iterator[tuple[str, str, str]]:
    """The mean misses before and after as bars of a width [cell]: name, bar, value."""
    shown, most = ShownUnits(system), max(one.before, one.after or 0.0) or 1.0
    for name, value in (("before", one.before), ("after", one.after)):
        if value is not None:
            yield name, "█" * max(1, round(value / most * width)), shown.length(value, 1)
