"""The flight or readout that would best distinguish two explanations, by the expected evidence.

Each explanation forecasts the readouts of a possible next flight. The divergence of the two forecasts is the expected
log Bayes factor (Lindley, On a Measure of the Information Provided by an Experiment, 1956; the divergence of two
normals, Kullback and Leibler, 1951). The smaller of its two values, one for each explanation being right, counts.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import BY_NAME, Flight
from fieldkit.inference.laplace.linearization import Tangent, launch_angle_slope, tangents
from fieldkit.inference.laplace.posterior import Fit, residual_variance
from fieldkit.messages import amount, message
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data, reading_sd
from fieldkit.model.rocket_model import Model
from fieldkit.motors import Found
from fieldkit.physics.effect import effect_named
from fieldkit.physics.history import history_of
from fieldkit.physics.setups import delays, recorded
from fieldkit.quantities import ShownUnits, in_system
from fieldkit.selection.candidates import EACH_GROUP, Place
from fieldkit.selection.extended_model import rocket_model
from fieldkit.shapes import Array, Float

Normal = tuple[Float[Array, "readout"], Float[Array, "readout readout"]]
"""Mean and covariance of readouts, in the units of the fit."""
Planned = tuple[str, Flight, Found]
"""Description of a flight, the flight, and its motor."""
BALLAST = 1.2
"""Dry mass of a ballasted flight, as a multiple of the configuration's. [1]"""
DELAY_INCREMENT = 2.0
"""Difference between successive delays on sale. [s]"""
BREEZE = 6.0
"""Wind of a windy day for a model rocket. [m/s]"""
ENOUGH_EVIDENCE_FRACTION = 0.9
"""A subset of readouts is enough if it has this fraction of the evidence of all. [1]"""


@dataclass(frozen=True, slots=True)
class Advice:
    """A proposed flight or measurement, its expected log Bayes factor, and the readouts to record.

    `subject` is the motor to fly, or the quantity to measure. `first` and `second` are the two explanations' forecasts
    of the apogee [m]; nan for a measurement. `expected` is in nats.
    """

    what: str
    subject: str
    readouts: tuple[str, ...]
    expected: float
    first: float = float("nan")
    second: float = float("nan")

    @property
    def in_words(self) -> str:
        """The advice in one line, in SI units."""
        return self.words()

    def words(self, system: str = "SI") -> str:
        """The advice in one line, in the units of a system."""
        shown, what, evidence = ShownUnits(system), in_system(self.what, system), _evidence_in_words(self.expected)
        if not self.readouts:
            return f"{what}: {evidence}"
        names = " and ".join(BY_NAME[name].title.lower() for name in self.readouts)
        first, second = shown.length(self.first), shown.length(self.second)
        apogees = f" (apogee {first.split()[0]} or {second})" if first != second else ""
        return f"{what} and record {names}{apogees}: {evidence}"

    @property
    def odds(self) -> str:
        """The odds that it is expected to give the right explanation: `2.6 to 1`."""
        odds = np.exp(min(self.expected, np.log(1000.0)))
        return "more than 999 to 1" if odds > 999 else f"{odds:.1f} to 1" if odds < 3 else f"{odds:.0f} to 1"


def _evidence_in_words(nats: float) -> str:
    """What one such flight or measurement is worth; the limits are those of Kass & Raftery, Bayes Factors, 1995: odds
    of 3 and of 20."""
    return "gives a hint" if nats < np.log(3) else "shows which is likelier" if nats < np.log(20) else "all but decides"


@dataclass(frozen=True, slots=True)
class Explanation:
    """Effects in their places, fitted to the flights so far."""

    places: tuple[Place, ...]
    fit: Fit


def informative_readouts(model: Model, first: Explanation, second: Explanation) -> list[Advice]:
    """The flights and measurements that would distinguish two explanations, the most informative first. Raises
    ImpossibleFlight for a flight without a dry mass."""
    tests = [*_flights(model, first, second), *_measurements(first), *_measurements(second)]
    return sorted(tests, key=lambda test: -test.expected)


def _flights(model: Model, first: Explanation, second: Explanation) -> Iterator[Advice]:
    plans = list(options(model))
    flown = [_planned(model, side, plans) for side in (first, second)]
    if any(made.names != side.fit.model.names for made, side in zip(flown, (first, second), strict=True)):
        return  # a planned flight would add terms that no flown flight has
    ahead = [_forecast(made, side) for made, side in zip(flown, (first, second), strict=True)]
    for row, (what, plan, _) in enumerate(plans):
        one, other = ((mean[row], cov[row]) for mean, cov in ahead)
        known = np.isfinite(one[0]) & np.isfinite(other[0])
        if not known[0]:
            continue
        readouts, expected = _readouts(one, other, np.flatnonzero(known).tolist())
        yield Advice(what, plan.motor, readouts, expected, float(np.exp(one[0][0])), float(np.exp(other[0][0])))


def _readouts(one: Normal, other: Normal, every: Sequence[int]) -> tuple[tuple[str, ...], float]:
    """The smallest set of one or two readouts with nearly all the evidence of all readouts, and its evidence. [nat]"""
    total = divergence(one, other, every)
    best = max(every, key=lambda i: divergence(one, other, [i]))
    alone = divergence(one, other, [best])
    if alone > ENOUGH_EVIDENCE_FRACTION * total or len(every) < 2:
        return (OBSERVED_READOUTS[best],), alone
    second = max((i for i in every if i != best), key=lambda i: divergence(one, other, [best, i]))
    return tuple(OBSERVED_READOUTS[i] for i in sorted((best, second))), divergence(one, other, [best, second])


def divergence(one: Normal, other: Normal, which: Sequence[int]) -> float:
    """Expected log Bayes factor between two normals over some readouts, the smaller of the two directions. [nat]"""
    rows = np.ix_(which, which)
    (a, s), (b, t) = ((mean[list(which)], cov[rows]) for mean, cov in (one, other))
    volume = float(np.linalg.slogdet(t)[1] - np.linalg.slogdet(s)[1])
    ahead = np.trace(np.linalg.solve(t, s)) + (a - b) @ np.linalg.solve(t, a - b) + volume
    back = np.trace(np.linalg.solve(s, t)) + (a - b) @ np.linalg.solve(s, a - b) - volume
    return float(min(ahead, back) - len(which)) / 2


def _measurements(side: Explanation) -> Iterator[Advice]:
    """Possible measurements on the ground, for effects with a known measurement error."""
    mean, sd = side.fit.moments()
    for place in side.places:
        effect = effect_named(place.effect)
        if not effect.measured or place.where == EACH_GROUP:
            continue
        row = side.fit.model.names.index(place.term_name())
        there = (np.array([mean[row]]), np.array([[sd[row] ** 2 + effect.measured**2]]))
        absent = (np.zeros(1), np.array([[effect.measured**2]]))
        where = f" ({place.where})" if place.where else ""
        yield Advice(effect.tell_apart + where, str(place), (), divergence(there, absent, [0]))


def options(model: Model) -> Iterator[Planned]:
    """Possible next flights: known motors in known configurations, in calm or wind, with ballast, with longer
    delays."""
    flights, found = model.flights, model.found
    last = {flight.config: flight for flight in flights}
    motors = {f"{item.motor.maker} {item.motor.designation}": row for row, item in enumerate(found)}
    windy = bool(np.nanmax(np.nan_to_num(recorded(flights, "wind")), initial=0.0) > 0)
    delay = delays(flights, found)
    for flight in last.values():
        for row in motors.values():
            own = flight.with_changes(
                motor=flights[row].motor, flight_id="", delay=flights[row].delay, tags=(), rail_angle=0.0, wind=0.0
            )
            title = f"fly {own.rocket} {own.config}".rstrip() + f" on the {own.motor}"
            yield f"{title} in calm air" if windy else title, own, found[row]
            if windy:
                yield message(f"{title} in a {amount(BREEZE, 'm/s')} wind"), own.with_changes(wind=BREEZE), found[row]
            if flight.dry_mass is not None:
                heavy = own.with_changes(dry_mass=BALLAST * flight.dry_mass)
                yield f"{title} with {BALLAST - 1:.0%} ballast", heavy, found[row]
            if np.isfinite(delay[row]):
                later = own.with_changes(delay=float(delay[row]) + DELAY_INCREMENT)
                yield f"{title} with a delay {DELAY_INCREMENT:.0f} s longer", later, found[row]


def _forecast(
    ahead: Model, side: Explanation
) -> tuple[Float[Array, "plan readout"], Float[Array, "plan readout readout"]]:
    """Mean and covariance of the readouts of planned flights, in the form that is compared."""
    at = side.fit.tangent.at
    terms = tuple(range(len(at)))
    (near,) = tangents(ahead, [(terms, at)], launch_angle_slope(ahead, at))
    best = int(np.argmax(side.fit.log_weight))
    mean = near.values + near.slope @ (side.fit.mean[best] - at)
    shared = near.slope @ side.fit.covariance[best] @ np.swapaxes(near.slope, 1, 2)
    return mean, shared + _own(ahead, near, best)


def _own(ahead: Model, near: Tangent, scale: int) -> Float[Array, "plan readout readout"]:
    """Covariance of the readouts of single flights around their expectation: scatter and reading."""
    scaled = near.scatter_slope * ahead.scatter_scales()[scale]
    raw = np.where(
        np.arange(len(OBSERVED_READOUTS)) == OBSERVED_READOUTS.index("apogee_to_eject"), 1.0, np.exp(near.values)
    )
    every = np.ones(raw.shape, bool)
    expected = Data(near.values, reading_sd(raw, ahead.hyperprior), every, np.ones(raw.shape))
    own = residual_variance(ahead, expected)[scale]
    return np.asarray(scaled @ np.swapaxes(scaled, 1, 2) + own[..., None] * np.eye(len(OBSERVED_READOUTS)))


def _planned(model: Model, side: Explanation, plans: Sequence[Planned]) -> Model:
    """The fitted model for planned flights, each as the next one: the same terms with their weights on those
    flights."""
    known, flown = model.history, len(model.flights)
    flights = [*known.flights, *(flight for _, flight, _ in plans)]
    found = [*known.found, *(motor for *_, motor in plans)]
    order = [*known.flight_index, *[flown] * len(plans)]
    area = {flight.config: own for flight, own in zip(known.flights, known.area, strict=True)}
    own = np.array([*known.area, *(area[flight.config] for _, flight, _ in plans)])
    history = replace(history_of(flights, found, flown, order), own_area=own)
    return rocket_model(history, side.places).part(slice(flown, None))
