"""Ledgers drawn from the generative model of a flight: several rockets of one flyer with known true parameters.

Shared terms (the flyer's fleet, motor types) are drawn once per ledger, other terms for each rocket, and scatter,
reading errors and their Student t tails for each flight, exactly as in the likelihood of the fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cache

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.tags import CHECKED_TAG
from fieldkit.model.hyperprior import READOUTS, Hyperprior
from fieldkit.model.readout_data import IS_LOGARITHMIC, reading_sd
from fieldkit.model.rocket_model import Model, apogee_scatter, base_model, shared_names
from fieldkit.model.scale import Scale
from fieldkit.model.simulated_readouts import bent, shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found, Motor, catalogue
from fieldkit.physics.history import field_setup, groups, history_of
from fieldkit.physics.unique import fly_unique
from fieldkit.shapes import Array, Float

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
TRIES = 50
"""Maximum number of redraws of a rocket that does not leave the pad."""


@dataclass(frozen=True, slots=True)
class LedgerTruth:
    """The truth of a planned flight: its apogee [m], and the logarithms of Cd and alpha."""

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


def ledger(rng: np.random.Generator, recipes: Sequence[LedgerRecipe], hyperprior: Hyperprior) -> list[GeneratedHistory]:
    """The histories of a flyer's rockets, one for each recipe."""
    common: dict[TermName, float] = {}
    return [_rocket(rng, f"R{number}", recipe, hyperprior, common) for number, recipe in enumerate(recipes)]


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
    model = base_model(history_of(flights, found, flown=len(both) - 1), hyperprior)
    drawn = dict(common)
    scatter_scale, reading_scale = _scale(rng, hyperprior.scatter), _scale(rng, hyperprior.reading)
    motor_scale = _scale(rng, hyperprior.motors) if hyperprior.motors else scatter_scale
    values = _terms(rng, model, drawn, scatter_scale, reading_scale)
    scatter = {str(kind.bends): rng.normal(size=(1, len(both))) * kind.sd * motor_scale for kind in model.scatter}
    readings = shown(model, values, scatter)
    tail = hyperprior.tail
    higher = rng.standard_t(tail, len(both)) * apogee_scatter(model) * scatter_scale
    apogee = float(readings["true"][0, -1] * np.exp(higher[-1]))
    if not np.all(np.nan_to_num(readings["apogee"][0]) > MIN_APOGEE) or apogee < MIN_APOGEE:
        return None
    noisy = _read(rng, model, readings, reading_scale, scatter_scale)
    noisy[recipe.flights // 2, 0] *= recipe.outlier
    common |= {name: drawn[name] for name in shared_names(model)}
    rows = [
        flight.with_changes(**{name: _number(noisy[i, READOUTS.index(name)]) for name in recipe.readouts})
        for i, flight in enumerate(flights)
    ]
    truth = LedgerTruth(apogee, *(float(bent(model, values, name)[0, -1]) for name in ("drag", "thrust")))
    return GeneratedHistory(tuple(zip(rows[:-1], found[:-1], strict=True)), both[-1], truth)


def _scale(rng: np.random.Generator, scale: Scale) -> float:
    return scale.median * float(np.exp(rng.normal(0, scale.log_sd)))


def _terms(
    rng: np.random.Generator, model: Model, drawn: dict[TermName, float], scatter: float, reading: float
) -> Float[Array, "1 term"]:
    """One draw of every term; those in `drawn` are reused, and the others are added to it."""
    by = {"": 1.0, "scatter": scatter, "reading": reading}
    for term in model.terms:
        if term.name not in drawn:
            value = np.nan
            while not term.low <= value <= term.high:
                value = float(rng.normal(term.mean, term.sd * by[term.scaled_by]))
            drawn[term.name] = value
    return np.array([[drawn[name] for name in model.names]])


def _read(
    rng: np.random.Generator, model: Model, readings: Mapping[str, Array], reading: float, scatter: float
) -> Float[Array, "flight readout"]:
    """Readouts with their errors, Student t."""
    raw = np.stack([readings[name][0] for name in READOUTS], axis=-1)
    sd = reading_sd(raw, model.hyperprior)
    width = reading * sd
    width[:, 0] = np.hypot(sd[:, 0], scatter * apogee_scatter(model))
    error = rng.standard_t(model.hyperprior.tail, raw.shape) * width
    return np.asarray(np.where(IS_LOGARITHMIC, raw * np.exp(error), raw + error))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
