"""A rocket's model solved in one pass over its response, without further simulations."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.inference.history.response import (
    MAX_DRAG_OFFSET,
    FlightResponse,
    drag_term,
    moved_at,
    part_of,
    reference,
    tangent,
)
from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.inference.laplace.outlier_weights import outlier_weights
from fieldkit.inference.laplace.posterior import Fit, probable_scales, solve
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import Model, Term, base_model, strength_term, usual_terms
from fieldkit.model.scale import Scale, scale_grid
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import effects
from fieldkit.physics.history import History
from fieldkit.physics.setups import differs_from_zero
from fieldkit.shapes import Array, Float, Int, Integers

SCATTER, READING, DOCUMENTS = (0.2, 0.5, 1.0, 2.2), (0.4, 1.1), (0.15, 0.6, 2.0)
"""Values of the scales in a one-pass fit, relative to their medians: a few over the bulk of their priors. [1]"""
DRAG_ROUNDS = 2
"""Number of times the drag is moved to its posterior mean."""
ROBUST_ROUNDS = 2
"""Number of updates of the weights of outliers."""


def few_scales(hyperprior: Hyperprior) -> Hyperprior:
    """The hyperprior with a few values of the scales of scatter, reading and documents instead of its grids. The scale
    of motors has one value: a fourth grid would multiply the time."""

    def few(scale: Scale, values: Sequence[float]) -> Scale:
        # the prior that follows from the flyer's other rockets is tabulated between the same ends
        return replace(scale, grid=tuple(scale.median * value for value in values), ends=scale.range)

    return replace(
        hyperprior,
        scatter=few(hyperprior.scatter, SCATTER),
        reading=few(hyperprior.reading, READING),
        documents=hyperprior.documents and few(hyperprior.documents, DOCUMENTS),
    )


@dataclass(frozen=True, slots=True, eq=False)
class PreparedFit:
    """The part of a linear fit that does not depend on readouts: the model of all flights and of the `flown` ones, with
    the terms that these or other rockets constrain, and the remaining terms (`fresh`)."""

    model: Model
    past: Model
    fresh: tuple[Term, ...]
    flown: int


@dataclass(frozen=True, slots=True)
class LinearFit:
    """A model of flown and planned flights, and the posterior given the flown ones.

    `fit` is for the flown flights alone; `near` linearizes all flights at the same point, whose drag differs from the
    reference by `offset`; `moved` is the effect of every candidate there. `fresh` are terms that act only on plans,
    such as the thrust of a motor never flown; the fitted model does not have them.
    """

    model: Model
    flown: int
    offset: float
    near: Tangent
    fit: Fit
    moved: Mapping[str, Float[Array, "flight readout"]]
    fresh: tuple[Term, ...] = ()


def history_model(
    history: History, hyperprior: Hyperprior, shared: SharedPrior | None = None, *, declared: bool
) -> Model:
    """The model of a history and its alternative plans; if `declared`, the effects of recorded conditions such as the
    wind act with their priors.

    Plans on motors that neither this rocket nor the others of the flyer have flown share the terms of one new motor.
    Raises ImpossibleFlight for a flight without a dry mass.
    """
    elsewhere = {str(name.group) for name in (shared.names if shared else ()) if name.level == "motor"}
    model = base_model(on_one_new_motor(history, elsewhere), hyperprior, shared)
    model = replace(model, history=history, hyperprior=few_scales(model.hyperprior))
    model = model.with_terms(*usual_terms(model))
    return model.with_terms(*declared_terms(history.flights)) if declared else model


def on_one_new_motor(history: History, known: Collection[str] = ()) -> History:
    """A history with one motor for all plans on motors that were not flown before and are not in `known`. The plans
    exclude each other, so this changes no forecast."""
    kinds, found = history.groups("motor"), history.found
    past = {*kinds[: history.flown], *known}
    new = [motor for kind, motor in zip(kinds, found, strict=True) if kind not in past]
    one_motor = tuple(motor if kind in past else new[0] for kind, motor in zip(kinds, found, strict=True))
    return replace(history, found=one_motor)


def declared_terms(flights: Sequence[Flight]) -> list[Term]:
    """Effects that act on all flights of a forecast if their column is recorded and not always zero."""
    every = np.ones(len(flights))
    return [
        strength_term(TermName(name, "effect"), effect, every)
        for name, effect in effects().items()
        if effect.declared and differs_from_zero(flights, effect.needs)
    ]


def prepared_fit(model: Model, flown: int) -> PreparedFit:
    """The preparation of a linear fit to the first `flown` flights of a model."""
    constrained, fresh = _constrained_part(model, flown)
    return PreparedFit(constrained, constrained.part(slice(flown)), fresh, flown)


def linear_fit(
    ready: PreparedFit,
    data: Data,
    response: FlightResponse,
    *,
    center: Float[Array, "term"] | None = None,
    start: float = 0.0,
) -> LinearFit:
    """The posterior given the flown flights, those in `data`, with log drag moved to its posterior mean in
    `DRAG_ROUNDS` steps, from `start` above that of the point `center` around which the response was simulated (by
    default the reference), in the units of the terms."""
    model, past, flown = ready.model, ready.past, ready.flown
    center = reference(model) if center is None else center
    level, offset = drag_term(past), start
    for _ in range(DRAG_ROUNDS):
        mean = usual_mean(ready, data, response, center, offset)
        offset = float(np.clip(mean[level] - center[level], -MAX_DRAG_OFFSET, MAX_DRAG_OFFSET))
    moved = moved_at(response, offset)
    near = tangent(model, moved, center, offset)
    fit = solve(past, data, part_of(near, slice(flown)))
    return LinearFit(model, flown, offset, near, fit, moved, ready.fresh)


def usual_mean(
    ready: PreparedFit, data: Data, response: FlightResponse, center: Float[Array, "term"], offset: float = 0.0
) -> Float[Array, "term"]:
    """The posterior mean at the medians of all scales, on which a point of linearization hardly depends, linear at a
    log drag that is `offset` [1] above that of the `center`; in the units of the terms. Derivation: a Gauss-Newton
    step."""
    near = tangent(ready.model, moved_at(response, offset), center, offset)
    usual = _usual_scales(ready.past.hyperprior)
    return np.asarray(solve(ready.past, data, part_of(near, slice(ready.flown)), which=usual).mean[0])


def _usual_scales(hyperprior: Hyperprior) -> Int[Integers, "1"]:
    """The point of the grid nearest to the medians of all scales."""
    values = np.stack(scale_grid(hyperprior.unknown_scales)[:-1])
    medians = np.array([[scale.median] for scale in hyperprior.unknown_scales])
    return np.array([np.argmin((np.log(values / medians) ** 2).sum(axis=0))])


def _constrained_part(model: Model, flown: int) -> tuple[Model, tuple[Term, ...]]:
    """A model with only the terms that its flown flights or other rockets constrain, and the remaining terms."""
    shared = model.shared.names if model.shared else ()
    known = [i for i, term in enumerate(model.terms) if term.weight[:flown].any() or term.name in shared]
    others = sorted(set(range(len(model.terms))) - set(known))
    return model.only(known), tuple(model.terms[i] for i in others)


def robust(linear: LinearFit) -> LinearFit:
    """The same fit with smaller weights for outliers, as in `fit_robustly`."""
    fit = linear.fit
    for turn in range(1, ROBUST_ROUNDS + 1):
        scales = probable_scales(fit) if turn < ROBUST_ROUNDS else None
        fit = solve(fit.model, replace(fit.data, trust=outlier_weights(fit)), fit.tangent, which=scales)
    return replace(linear, fit=fit)
