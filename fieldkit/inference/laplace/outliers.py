"""Readouts that do not fit the rest of their flight: they teach no forecast until the flyer says that they are right.

The field ensemble foretells each readout from the others (`fieldkit.inference.network.outliers`), with an error that
one good flight in a hundred exceeds. A tag `checked` on the flight lets such a readout teach. The other readouts of the
flight teach as ever.
"""

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.errors import DamagedModel
from fieldkit.flight import CHECKED_TAG, Flight
from fieldkit.model.observations import INDEPENDENT_READOUTS, observe
from fieldkit.motors import Found

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

MIN_READOUTS = 2
"""Readouts of a flight from which on one can be predicted from the others. [1]"""


def consistency_check(flights: Sequence[Flight], found: Sequence[Found]) -> tuple[tuple[Flight, ...], tuple[str, ...]]:
    """The flights without inconsistent readouts, and a line for each readout that was removed."""
    judged = [row for row, flight in enumerate(flights) if _can_be_judged(flight)]
    if not judged:
        return tuple(flights), ()
    from fieldkit.inference.network.outliers import derived_from, misfit, warnings

    try:
        ensemble = _ensemble()
    except DamagedModel as error:
        return tuple(flights), (f"whether readouts fit their flights was not looked at: {error}",)
    observed = observe([flights[row] for row in judged], [found[row] for row in judged])
    which = misfit(ensemble, observed)
    said = warnings(ensemble, observed, which)
    kept, lines = list(flights), []
    for place in np.flatnonzero(which >= 0):
        row = judged[place]
        kept[row] = flights[row].with_changes(**dict.fromkeys(derived_from(INDEPENDENT_READOUTS[which[place]])))
        name = flights[row].flight_id
        lines.append(f"flight {name}: {said[place]}; if it is right, `fieldkit tag {name} {CHECKED_TAG}`")
    return tuple(kept), tuple(lines)


def _can_be_judged(flight: Flight) -> bool:
    readouts = sum(flight.number(name) is not None for name in INDEPENDENT_READOUTS)
    return flight.clean and CHECKED_TAG not in flight.tags and flight.dry_mass is not None and readouts >= MIN_READOUTS


@cache
def _ensemble() -> "Ensemble":
    from fieldkit.inference.network.field_ensemble import load_field

    return load_field()
