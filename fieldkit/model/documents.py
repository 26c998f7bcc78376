"""How closely a flyer's motors, masses and devices keep to their documents: a hypothesis that the flights decide.

A family of hyperpriors on one continuous scale: at `CERTIFIED_SCALE` the standard deviations are those of
`CERTIFIED_PRIOR`, at 1 those of `START`, and beyond it wider. On a logarithmic scale they are linear in between, and an
effect that `CERTIFIED_PRIOR` lacks is proportional to the scale. The prior of the scale is half-Cauchy around 1, whose
tail lets a flyer with weighed rockets and one lot of motors be exact, and another be far off. Evidence weighs the
scales, so the plain model explains a deviation unless this flyer's other motors and masses agree with their documents.
"""

from dataclasses import replace
from functools import cache
from types import MappingProxyType

import numpy as np

from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import START, Hyperprior
from fieldkit.model.scale import HALF_CAUCHY, Scale

CERTIFIED_SCALE = 0.1
"""The scale at which documents are exact: the thrust of motor types varies by 0.7% instead of 5%. [1]"""
LEVELS_OF_DOCUMENTS = ("fleet", "drift", "rocket", "config", "motor", "rocket_motor", "day")
"""Levels whose effects are deviations from documents; a single flight and a lot scatter anyway."""
SEARCH_GRID = (0.15, 1.0)
"""Values of the scale while sets of effects are tried. [1]"""


@cache
def power(quantity: str, level: str) -> float:
    """The power of the scale that multiplies the standard deviation of one random effect; 0 if documents do not
    state it, as the drag of a rocket, or by how much a device smooths a motor's spike of thrust. [1]

    Derivation: the scale to this power takes `START` to `CERTIFIED_PRIOR`.
    """
    start, exact = START.sd(quantity, level), CERTIFIED_PRIOR.sd(quantity, level)
    beyond = (quantity == "drag" and level != "config") or (quantity, level) == ("peak_accel", "motor")
    if not start or level not in LEVELS_OF_DOCUMENTS or beyond:
        return 0.0
    return max(float(np.log(exact / start) / np.log(CERTIFIED_SCALE)), 0.0) if exact else 1.0


def with_documents(hyperprior: Hyperprior) -> Hyperprior:
    """A hyperprior of forecasts with the scale of documents unknown, at 1 until the fit has converged."""
    return replace(hyperprior, documents=Scale((1.0,), 1.0, 1.0, spread=HALF_CAUCHY))


def _search_prior() -> Hyperprior:
    """The hyperprior of the search for effects: `START`, with the scale of documents unknown.

    The search sees one rocket, whose flights do not separate it from its fleet: the variances add.
    """
    sds = {key: sd for key, sd in START.sds.items() if not key.endswith(".fleet")}
    for quantity in (key.partition(".")[0] for key in START.sds if key.endswith(".fleet")):
        sds[f"{quantity}.rocket"] = float(np.hypot(START.sd(quantity, "fleet"), START.sd(quantity, "rocket")))
    return replace(
        START,
        sds=MappingProxyType(sds),
        scatter=replace(START.scatter, grid=tuple(np.geomspace(0.15, 3.0, 5).tolist())),
        reading=replace(START.reading, grid=tuple(np.geomspace(0.25, 2.0, 3).tolist())),
        documents=Scale(SEARCH_GRID, 1.0, 1.0, spread=HALF_CAUCHY),
    )


SEARCH_PRIOR = _search_prior()
"""The hyperprior with which the search looks for effects: nothing in it was learned from flights."""
