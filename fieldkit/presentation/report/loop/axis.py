"""The axis against which residuals are drawn: the column of the verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import BY_NAME
from fieldkit.physics.effect import effect_named
from fieldkit.presentation.condition_axis import in_units
from fieldkit.selection.residual import columns_of
from fieldkit.services.findings import Findings
from fieldkit.shapes import Array, Float

TITLES = {"flight_number": "flight, in the order flown", "hour": "hour of the day"}


@dataclass(frozen=True, slots=True)
class Axis:
    """A title, a value for each flight (nan if not recorded), and the names of the values if they are groups."""

    title: str
    values: Float[Array, "flight"]
    names: Sequence[str] = ()


def axis(found: Findings, system: str = "SI") -> Axis:
    """The column of the accepted effect, or else of the strongest correlation, or else the order flown; in the units of
    a system.
    """
    diagnosis = found.diagnosis
    for trial in diagnosis.accepted[:1]:
        effect = effect_named(trial.candidate.place.effect)
        if effect.needs:
            column = BY_NAME[effect.needs]
            return Axis(*in_units(column.header, diagnosis.model.recorded(column.name), system))
        if trial.candidate.place.where and not trial.candidate.place.since:
            return _grouped(found, effect.per)
        if effect.grows or trial.candidate.place.since:
            return _numbered(found, "flight_number", system)
    if found.patterns and (diagnosis.accepted or found.patterns[0].p < 0.1):
        best = found.patterns[0].against
        return _numbered(found, best, system) if best in columns_of(diagnosis) else _grouped(found, best)
    return _numbered(found, "flight_number", system)


def _numbered(found: Findings, name: str, system: str) -> Axis:
    title, values = in_units(name, columns_of(found.diagnosis)[name], system)
    return Axis(TITLES.get(name, title), values)


def _grouped(found: Findings, per: str) -> Axis:
    model = found.diagnosis.model
    own = model.groups(per)
    names = list(dict.fromkeys(own))
    return Axis(per, np.array([names.index(name) for name in own], float), names)
