"""Ledgers drawn from the generative model of a flight: several rockets of one flyer with known true parameters.

Shared terms (the flyer's fleet, motor types), the flyer's scatter and the scale of documents are drawn once per ledger,
other terms and scales for each rocket, and scatter, causes of single flights, reading errors and their Student t tails
for each flight, exactly as in the likelihood of the fit. The next flight is a usual one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from functools import cache
from types import MappingProxyType

import numpy as np
from scipy import stats

from fieldkit.flight import Flight
from fieldkit.flight.tags import CHECKED_TAG
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.model.causes import USUAL_PROBABILITY, signatures
from fieldkit.model.documents import with_documents
from fieldkit.model.hyperprior import READOUTS, Hyperprior
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, compared, reading_sd
from fieldkit.model.rocket_model import Model, apogee_scatter, shared_names
from fieldkit.model.scale import Scale
from fieldkit.model.simulated_readouts import bent, shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found, Motor, catalogue
from fieldkit.physics.history import field_setup, groups, history_of
from fieldkit.physics.unique import fly_unique
from fieldkit.selection.extended_model import rocket_model
from fieldkit.shapes import Array, Flags, Float

SUBSETS: Mapping[str, tuple[str, ...]] = {
    "apogee": ("apogee",),
    "apogee, speed": ("apogee", "top_speed"),
    "no inertial": ("apogee", "top_speed", "coast_to_apogee", "apogee_to_eject"),
    "all": READOUTS,
}
"""Readouts that an altimeter records."""
IMPULSES = (4.0, 160.0)
"""Total impulse of the motors that fly. [N s]"""
THRUST_TO_WEIGHT = (6.0, 18.0)
"""Bounds of the average thrust-to-weight ratio at lift-off. [1]"""
MIN_APOGEE = 20.0
"""Minimum apogee; rockets below it are drawn again. [m]"""
DIAMETER_KNOWN = 0.75
"""Fraction of rockets with a recorded diameter. [1]"""
SAME_DAY = 0.4
"""Fraction of flights on the same day as the previous one. [1]"""
NEAREST_MOTORS = 12
"""Number of motors with similar thrust from which a rocket's other motors are drawn."""
SCALE_VALUES = 400
"""Number of values from which a scale is drawn. [1]"""
TRIES = 50
"""Maximum number of redraws of a rocket that does not leave the pad."""


@dataclass(frozen=True, slots=True)
class LedgerTruth:
    """The truth of a planned flight: its apogee as an altimeter shows it [m], and the logarithms of Cd and alpha."""

    apogee: float
    log_cd: float
    log_alpha: float


@dataclass(frozen=True, slots=True)
class GeneratedHistory:
    """The flights of one rocket with their motors, the next flight, and its truth."""

    flown: tuple[tuple[Flight, Found], ...]
    plan: tuple[Flight, Found]
    truth: LedgerTruth


@dataclass(frozen=True, slots=True)
class LedgerRecipe:
    """Parameters of a rocket's history: numbers of flights and motors, and the readouts.

    `new_motor` plans a flight on a motor that was never flown; a `diameter` of None is recorded at random. `outlier`
    multiplies the apogee of the middle flight [1].
    """

    flights: int
    motors: int = 1
    readouts: tuple[str, ...] = READOUTS
    new_motor: bool = False
    diameter: bool | None = None
    outlier: float = 1.0


def random_recipe(rng: np.random.Generator) -> LedgerRecipe:
    """A recipe with 1 to 12 flights, 1 to 3 motors, a random set of readouts, and a new motor for one plan in
    five."""
    flights = int(rng.integers(1, 13))
    subset = list(SUBSETS)[int(rng.integers(len(SUBSETS)))]
    motors = int(rng.integers(1, min(flights, 3) + 1))
    return LedgerRecipe(flights, motors, SUBSETS[subset], bool(rng.random() < 0.2))


@dataclass(frozen=True, slots=True)
class DrawnFlights:
    """Flights drawn from a model with one value of every scale: its terms in their units, and the readouts in SI."""

    terms: Float[Array, "term"]
    readouts: Float[Array, "flight readout"]


def ledger(rng: np.random.Generator, recipes: Sequence[LedgerRecipe], hyperprior: Hyperprior) -> list[GeneratedHistory]:
    """The histories of a flyer's rockets, one for each recipe."""
    common: dict[TermName, float] = {}
    flyer = with_documents(hyperprior)
    if flyer.documents is not None:
        flyer = replace(flyer, documents=drawn_scale(rng, flyer.documents))
    flyer = replace(flyer, scatter=_of_flyer(rng, flyer.scatter))
    return [_rocket(rng, f"R{number}", recipe, flyer, common) for number, recipe in enumerate(recipes)]


def drawn_scale(rng: np.random.Generator, scale: Scale) -> Scale:
    """One value of a scale from its prior; of documents from the values over which a fit sums."""
    fine = (
        scale.refined()
        if scale.range[0] == scale.range[1]
        else replace(scale, points=SCALE_VALUES).between(*scale.range)
    )
    chance = np.exp(fine.log_prior - np.logaddexp.reduce(fine.log_prior))
    return replace(scale, grid=(float(rng.choice(fine.values, p=chance)),), step=0.0)


def _of_flyer(rng: np.random.Generator, scale: Scale) -> Scale:
    """The prior of a rocket's scale given one value of the flyer's; the same if rockets do not share it."""
    if not scale.within:
        return scale
    flyer = drawn_scale(rng, replace(scale, spread=float(np.sqrt(scale.spread**2 - scale.within**2))))
    return replace(scale, median=flyer.grid[0], log_sd=scale.within, spread=0.0, within=0.0)


def _rocket(
    rng: np.random.Generator, name: str, recipe: LedgerRecipe, hyperprior: Hyperprior, common: dict[TermName, float]
) -> GeneratedHistory:
    for _ in range(TRIES):
        both = _planned(rng, name, recipe)
        history = _flown(rng, both, recipe, hyperprior, common)
        if history is not None:
            return history
    raise RuntimeError(f"{name}: none of {TRIES} rockets flew above {MIN_APOGEE:g} m")


@cache
def _motors() -> tuple[Motor, ...]:
    """Certified motors of suitable sizes, in an order independent of the catalog's."""
    low, high = IMPULSES
    every = {(m.maker, m.designation): m for m in catalogue().motors if low <= m.total_impulse <= high}
    return tuple(every[name] for name in sorted(every))


def _planned(rng: np.random.Generator, name: str, recipe: LedgerRecipe) -> list[tuple[Flight, Found]]:
    """The flights of a rocket and the next one, before their simulation."""
    motors = _choice_of_motors(rng, recipe.motors + recipe.new_motor)
    thrust = float(np.mean([motor.average_thrust for motor in motors]))
    lift_off = thrust / 9.81 / float(np.exp(rng.uniform(*np.log(THRUST_TO_WEIGHT))))
    mass = max(lift_off - float(np.mean([motor.loaded_mass for motor in motors])), 0.3 * lift_off)
    caliber = 0.060 * (mass / 0.4) ** 0.2 * float(np.exp(rng.normal(0, 0.15)))
    known = rng.random() < DIAMETER_KNOWN if recipe.diameter is None else recipe.diameter
    base = Flight(rocket=name, config="A", site="field", dry_mass=mass, diameter=caliber if known else None)
    base = base.with_changes(tags=(CHECKED_TAG,), temperature=float(rng.normal(291, 7)))
    flown = [motors[i % recipe.motors] for i in range(recipe.flights)]
    last = motors[-1] if recipe.new_motor else motors[int(rng.integers(recipe.motors))]
    day, rows = datetime(2024, 4, 6, 10), []
    for number, motor in enumerate([*flown, last]):
        day = day + (timedelta(hours=1) if rng.random() < SAME_DAY else timedelta(days=14))
        flight = base.with_changes(flight_id=f"{name}-{number}", motor=motor.designation, date_time=day)
        rows.append((flight, Found(motor, None)))
    return _with_delays(rng, rows, caliber)


def _choice_of_motors(rng: np.random.Generator, count: int) -> list[Motor]:
    """Different motors of about the same thrust."""
    first = _motors()[int(rng.integers(len(_motors())))]
    others = [motor for motor in _motors() if motor.designation != first.designation]
    near = sorted(others, key=lambda motor: abs(np.log(motor.average_thrust / first.average_thrust)))[:NEAREST_MOTORS]
    return [first, *(near[i] for i in rng.permutation(NEAREST_MOTORS)[: count - 1])]


def _with_delays(
    rng: np.random.Generator, rows: list[tuple[Flight, Found]], caliber: float
) -> list[tuple[Flight, Found]]:
    """Each motor type with a delay near the coast of a rocket of Cd 0.6."""
    flights, found = zip(*rows, strict=True)
    area = np.full(len(rows), np.pi / 4 * caliber**2 * 0.6)
    coast = fly_unique(field_setup(flights, found, area)).coast_time
    kinds = groups(flights, found, "motor")
    delays: dict[str, float] = {}
    for kind, seconds in zip(kinds, coast.tolist(), strict=True):
        delays.setdefault(kind, max(2.0, float(np.round(seconds * np.exp(rng.normal(0.1, 0.2))))))
    return [(flight.with_changes(delay=delays[kind]), motor) for (flight, motor), kind in zip(rows, kinds, strict=True)]


def _flown(
    rng: np.random.Generator,
    both: Sequence[tuple[Flight, Found]],
    recipe: LedgerRecipe,
    hyperprior: Hyperprior,
    common: dict[TermName, float],
) -> GeneratedHistory | None:
    """Simulated flights from the model; None for a rocket that does not leave the pad or barely does."""
    flights, found = zip(*both, strict=True)
    model = rocket_model(history_of(flights, found, flown=len(both) - 1), (), hyperprior)
    known_scale = model.hyperprior.documents
    scales = [one if one is known_scale else drawn_scale(rng, one) for one in model.hyperprior.unknown_scales]
    model = replace(model, hyperprior=model.hyperprior.with_scales(*scales))
    drawn = drawn_flights(rng, model, np.isin(OBSERVED_READOUTS, recipe.readouts), common)
    readouts = drawn.readouts.copy()
    if not np.all(np.nan_to_num(readouts[:, 0]) > MIN_APOGEE):
        return None
    readouts[recipe.flights // 2, 0] *= recipe.outlier
    known = dict(zip(model.names, drawn.terms.tolist(), strict=True))
    common |= {name: known[name] for name in shared_names(model)}
    rows = [
        flight.with_changes(**{name: _number(own[OBSERVED_READOUTS.index(name)]) for name in recipe.readouts})
        for flight, own in zip(flights, readouts, strict=True)
    ]
    log_cd, log_alpha = (float(bent(model, drawn.terms[None], name)[0, -1]) for name in ("drag", "thrust"))
    truth = LedgerTruth(float(readouts[-1, 0]), log_cd, log_alpha)
    return GeneratedHistory(tuple(zip(rows[:-1], found[:-1], strict=True)), both[-1], truth)


def drawn_flights(
    rng: np.random.Generator, model: Model, seen: Flags, known: Mapping[TermName, float] = MappingProxyType({})
) -> DrawnFlights:
    """Flights from a model with one value of every scale; the last one is a usual one. `seen` marks the readouts that
    flights have: only those can be misread. Terms that are `known` are not drawn."""
    sds, tail = term_sds(model)[0], model.hyperprior.tail
    drawn = [_within(rng, one.mean, sd, one.low, one.high) for one, sd in zip(model.terms, sds, strict=True)]
    values = np.array([known.get(name, value) for name, value in zip(model.names, drawn, strict=True)])
    scatter = {
        str(kind.bends): kind.sd * scale * rng.normal(size=(1, len(model.flights)))
        for kind, scale in zip(model.scatter, model.scatter_scales()[0], strict=True)
    }
    expected = shown(model, values[None], scatter)
    raw = np.stack([expected[name][0] for name in OBSERVED_READOUTS], axis=-1)
    (scatter_scale,), (reading_scale,), _ = model.hyperprior.scales()
    sd = reading_sd(raw, model.hyperprior)
    sd = np.where(np.array(OBSERVED_READOUTS) == "apogee", sd, sd * reading_scale)
    sd[:, 0] = np.hypot(sd[:, 0], scatter_scale * apogee_scatter(model))
    error = sd * rng.standard_t(tail, size=raw.shape)
    error[:-1] += drawn_causes(rng, model, values, np.broadcast_to(seen, raw.shape))[:-1]
    return DrawnFlights(values, np.where(IS_LOGARITHMIC, raw * np.exp(error), raw + error))


def drawn_causes(
    rng: np.random.Generator, model: Model, at: Float[Array, "term"], seen: Flags
) -> Float[Array, "flight readout"]:
    """The change of every flight's readouts as compared [1] or [s] by its cause, zero on a usual flight."""
    expected = shown(model, at[None], {})
    usual = compared(np.stack([expected[name][0] for name in OBSERVED_READOUTS], axis=-1))
    known = signatures(model, at, usual, seen)
    change = np.zeros_like(usual)
    for row in range(len(usual)):
        chance = np.append(np.exp(known.log_prior[:, row]), USUAL_PROBABILITY)
        drawn = int(rng.choice(len(chance), p=chance / chance.sum()))
        if drawn < len(known.cause):
            change[row] = rng.normal(known.shift[drawn, row], np.abs(known.spread[drawn, row]))
    return change


def _within(rng: np.random.Generator, mean: float, sd: float, low: float, high: float) -> float:
    below, above = (float(stats.norm.cdf(end, mean, sd)) for end in (low, high))
    return float(stats.norm.ppf(rng.uniform(below, above), mean, sd))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
