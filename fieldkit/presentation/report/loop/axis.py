"""What residuals are drawn against: the column that the verdict is about."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import BY_NAME
from fieldkit.model.rocket_model import groups
from fieldkit.physics.effect import effects
from fieldkit.physics.setups import recorded
from fieldkit.selection.residual import columns_of
from fieldkit.services.findings import Findings
from fieldkit.shapes import Array, Float

TITLES = {
    "flight_number": "flight, in the order flown",
    "hour": "hour of the day",
    "expected_top_speed_mps": "expected top speed [m/s]",
}


@dataclass(frozen=True, slots=True)
class Axis:
    """A title, a place for each flight (nan for not recorded), and names of the places if they are groups."""

    title: str
    values: Float[Array, "flight"]
    names: Sequence[str] = ()


def axis(found: Findings) -> Axis:
    """By the effect that is accepted, else by what the residual goes with most, else in the order flown."""
    diagnosis = found.diagnosis
    for trial in diagnosis.accepted[:1]:
        effect = effects()[trial.candidate.place.effect]
        if effect.needs:
            column = BY_NAME[effect.needs]
            return Axis(f"{column.title.lower()} [{column.unit}]", recorded(diagnosis.model.flights, column.name))
        if trial.candidate.place.where and not trial.candidate.place.since:
            return _grouped(found, effect.per)
        if effect.grows or trial.candidate.place.since:
            return _numbered(found, "flight_number")
    if found.patterns and (diagnosis.accepted or found.patterns[0].p < 0.1):
        best = found.patterns[0].against
        return _numbered(found, best) if best in columns_of(diagnosis) else _grouped(found, best)
    return _numbered(found, "flight_number")


def _numbered(found: Findings, name: str) -> Axis:
    return Axis(TITLES.get(name, name.replace("_", " ")), columns_of(found.diagnosis)[name])


def _grouped(found: Findings, per: str) -> Axis:
    model = found.diagnosis.model
    own = groups(model.flights, model.found, per)
    names = list(dict.fromkeys(own))
    return Axis(per, np.array([names.index(name) for name in own], float), names)
