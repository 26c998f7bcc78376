"""Simulated readouts of flights at a few drag coefficients, and their derivatives for each term and each effect.

All flights and all perturbations are simulated in one batch. Results are interpolated between the drag coefficients, so
that a fit can move its point of linearization without new simulations. The shifts of effects, and
the derivatives that matter less, are simulated at the middle one only.

Derivation: derivatives are difference quotients of simulations, and values between the drag coefficients are those of
Lagrange's polynomial (1795).
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import Effect, effects
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float

REFERENCE_LOG_DRAG = float(np.log(0.6))
"""Logarithm of the reference drag coefficient of the simulations. [1]"""
REFERENCE_OPENING = 0.6
"""Opening time of the parachute at the reference. [s]"""
DRAG_OFFSETS = (-0.45, 0.0, 0.45)
"""Logarithms of drag over the reference between which readouts are interpolated. [1]"""
MIDDLE = DRAG_OFFSETS.index(0.0)
"""Number of the drag at which shifts are simulated that are not simulated at each. [1]"""
MAX_DRAG_OFFSET = 0.9
"""Maximum distance of the logarithm of drag from the reference. [1]"""
STEPS = {"thrust": 0.05, "mass": 0.03}
"""Finite-difference step of the properties whose derivatives depend most on drag, in the unit of their terms."""
STEPS_AT_MIDDLE = {"stretch": 0.05, "opening": 0.3, "tilt": 1.0}
"""Finite-difference step of the other properties, whose derivatives are simulated at the middle drag only."""
DELAY_STEP = 0.08
"""Step of the log delay to both sides, because readouts have a kink when ejection is at apogee. [1]"""
GROWN_FLIGHTS = 8.0
"""Number of earlier flights for the step of an effect that grows from flight to flight. [1]"""
_OF_READOUTS = dict(zip(OBSERVED_READOUTS, np.eye(len(OBSERVED_READOUTS)), strict=True))
"""The effect of a unit of a reading's bias."""


@dataclass(frozen=True, slots=True)
class FlightResponse:
    """Readouts in the form that a fit compares, at each of `DRAG_OFFSETS`, and their derivatives.

    `moved` are the effects of one unit of a property or of the fitted value of an effect: of those in `names` at each
    of these drags, of those in `names_at_middle` at the middle one. The first of `names` is empty, for the readouts
    themselves. An effect with several `starts` has one entry for each, named by the effect and the number of the start.
    """

    names: tuple[str, ...]
    moved: Float[Array, "quantity drag flight readout"]
    names_at_middle: tuple[str, ...]
    moved_at_middle: Float[Array, "other flight readout"]

    def part(self, rows: slice | list[int]) -> "FlightResponse":
        """The selected flights."""
        return FlightResponse(self.names, self.moved[:, :, rows], self.names_at_middle, self.moved_at_middle[:, rows])


def secant(effect: Effect) -> tuple[float, ...]:
    """The fitted values at which the shift of an effect is simulated, neither small nor extreme, in the unit of the
    effect."""
    prior = effect.prior
    if effect.starts:
        return effect.starts
    return (float(np.clip((abs(prior.mean) + prior.sd) * (GROWN_FLIGHTS if effect.grows else 1.0), 1e-6, None)),)


def respond(
    history: History,
    acting: Collection[str] | None = None,
    around: Mapping[str, Float[Array, "flight"]] = MappingProxyType({}),
) -> FlightResponse:
    """The response of flights and plans to the `acting` effects, by default all, with coarse thrust curves and steps,
    from one batch of simulated flights.

    `around` are the values of properties at which each flight is simulated, relative to the reference. Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    known = {name: effect for name, effect in effects().items() if acting is None or name in acting}
    count = len(history.flights)
    places = [(name, value) for name, effect in known.items() for value in secant(effect)]
    each_drag = [("", 0.0), *STEPS.items()]
    at_middle = [*STEPS_AT_MIDDLE.items(), ("delay", DELAY_STEP), ("delay", -DELAY_STEP)]
    stepped = len(each_drag) * len(DRAG_OFFSETS)
    placed = stepped + len(at_middle)
    bends = {kind: np.zeros((placed + len(places), count)) for kind in (*STEPS, *STEPS_AT_MIDDLE, "delay", "drag")}
    for row, (kind, step) in enumerate([*each_drag * len(DRAG_OFFSETS), *at_middle]):
        if kind:
            bends[kind][row] = step
    bends["opening"] += REFERENCE_OPENING
    bends["drag"] += REFERENCE_LOG_DRAG
    for kind, own in around.items():
        bends[kind] += own
    bends["drag"][:stepped] += np.repeat(DRAG_OFFSETS, len(each_drag))[:, None]
    values = np.zeros((placed + len(places), len(places)))
    values[placed:] = np.diag([value for _, value in places])
    terms = tuple(Term(TermName(name, "start", value), known[name], 0.0, 1.0, np.ones(count)) for name, value in places)
    model = Model(history, terms, coarse=True)
    readings = shown(model, values, bends)
    flown = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
    by_drag = flown[:stepped].reshape(len(DRAG_OFFSETS), len(each_drag), count, -1)
    with np.errstate(invalid="ignore"):
        moved = np.nan_to_num(by_drag - by_drag[:, :1], posinf=0.0, neginf=0.0)
        others = np.nan_to_num(flown[stepped:] - by_drag[MIDDLE, 0], posinf=0.0, neginf=0.0)
    moves = {"": by_drag[:, 0]}
    moves |= {kind: moved[:, row] / step for row, (kind, step) in enumerate(each_drag) if kind}
    once = {kind: others[row] / step for row, (kind, step) in enumerate(at_middle) if kind in STEPS_AT_MIDDLE}
    there, back = (others[row] for row, (kind, _) in enumerate(at_middle) if kind == "delay")
    once["delay"] = (there - back) / (2 * DELAY_STEP)
    for name, effect in known.items():
        rows = [placed - stepped + row for row, (other, _) in enumerate(places) if other == name]
        size = 1.0 if effect.starts else secant(effect)[0]
        once |= {started(name, number): others[row] / size for number, row in enumerate(rows)}
    return FlightResponse(tuple(moves), np.stack(list(moves.values())), tuple(once), np.stack(list(once.values())))


def started(effect: str, number: int) -> str:
    """The name of the entry for one of an effect's starts."""
    return f"{effect} {number}"


def _interpolation(offset: float) -> tuple[Float[Array, "drag"], Float[Array, "drag"]]:
    """Lagrange interpolation weights of the simulated drags, and their derivatives."""
    low, middle, high = DRAG_OFFSETS
    nodes = np.array(DRAG_OFFSETS)
    others = np.array([[middle, high], [low, high], [low, middle]])
    scale = (nodes[:, None] - others).prod(axis=1)
    return (offset - others).prod(axis=1) / scale, (2 * offset - others.sum(axis=1)) / scale


def moved_at(response: FlightResponse, offset: float) -> dict[str, Float[Array, "flight readout"]]:
    """Every quantity of a response at an offset of the log drag [1], and as `drag` the derivative of the readouts with
    respect to it."""
    weights, steeper = _interpolation(offset)
    shape = response.moved.shape
    with np.errstate(invalid="ignore"):  # infinite figures of a flight that does not lift
        along = (weights @ response.moved.reshape(*shape[:2], -1)).reshape(shape[0], *shape[2:])
        steeply = (steeper @ response.moved[0].reshape(shape[1], -1)).reshape(shape[2:])
    found = dict(zip(response.names, along, strict=True))
    found |= zip(response.names_at_middle, response.moved_at_middle, strict=True)
    return found | {"drag": np.nan_to_num(steeply)}


def drag_term(model: Model) -> int:
    """The term for the level of drag."""
    return next(i for i, term in enumerate(model.terms) if term.bends == "drag" and np.all(term.weight == 1.0))


def slopes(
    terms: Sequence[Term], moved: Mapping[str, Float[Array, "flight readout"]]
) -> Float[Array, "flight readout term"]:
    """Derivatives of the readouts per unit of each term, from the result of `moved_at`."""
    if not terms:
        return np.empty((*moved[""].shape, 0))
    bends = [term.bends if isinstance(term.bends, str) else started(term.name.quantity, 0) for term in terms]
    kinds = list(dict.fromkeys(bends))
    known = np.empty((*moved[""].shape, len(kinds)))
    for place, kind in enumerate(kinds):
        known[..., place] = moved[kind] if kind in moved else _OF_READOUTS[kind]
    weight = np.array([term.weight for term in terms]).T
    return np.asarray(known[..., [kinds.index(kind) for kind in bends]] * weight[:, None])


def reference(model: Model) -> Float[Array, "term"]:
    """The values of a model's terms at the reference, in their units."""
    at = np.array([REFERENCE_OPENING if term.bends == "opening" else 0.0 for term in model.terms])
    at[drag_term(model)] = REFERENCE_LOG_DRAG
    return at


def off_reference(model: Model, center: Float[Array, "term"]) -> dict[str, Float[Array, "flight"]]:
    """How far properties of each flight are from the reference at the values `center` of a model's terms, for
    `respond`; in the units of the terms."""
    found: dict[str, Float[Array, "flight"]] = {}
    for term, off in zip(model.terms, center - reference(model), strict=True):
        if off:
            kind = str(term.bends)
            found[kind] = found.get(kind, np.zeros(len(term.weight))) + off * term.weight
    return found


def tangent(
    model: Model, moved: Mapping[str, Float[Array, "flight readout"]], center: Float[Array, "term"], offset: float
) -> Tangent:
    """Values and derivatives for a model's terms at a log drag that differs by `offset` [1] from that of the point
    `center` around which the flights were simulated, from the result of `moved_at`."""
    at = center.copy()
    at[drag_term(model)] += offset
    slope = slopes(model.terms, moved)
    scatter = [moved.get(kind.bends, np.zeros(moved[""].shape)) * kind.sd for kind in model.scatter]
    return Tangent(at, moved[""], slope, np.stack(scatter, axis=-1))


def part_of(near: Tangent, rows: slice) -> Tangent:
    """The selected flights of a tangent."""
    return Tangent(near.at, near.values[rows], near.slope[rows], near.scatter_slope[rows])
