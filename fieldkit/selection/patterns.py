"""Patterns that no effect explains: single days, the hour, a lasting change, a site, any recorded condition.

A pattern in a number is any smooth function of it: a Gaussian process, expressed by its few independent components at
the flown flights (Karhunen and Loeve; Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, section
4.3) and extended to other flights by the Nystroem method.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import time
from functools import partial

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.further import headers, names_a_lot
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.term_names import TermName
from fieldkit.physics.history import History
from fieldkit.physics.setups import recorded
from fieldkit.selection.candidates import Candidate, Pattern, Place
from fieldkit.selection.covariates import known_before, own_numbers
from fieldkit.shapes import Array, Float

Weigh = Callable[[Sequence[Flight]], Array]
"""The weight of a pattern on each of a rocket's flights in the order flown, planned ones last; one column per
component."""
PatternKind = Mapping[Pattern, Weigh]
"""Patterns of one kind."""
PATTERN_DRAG_SD = 0.15
"""Prior standard deviation of the log drag in a pattern. [1]"""
PATTERN_SDS = {"drag": PATTERN_DRAG_SD, "thrust": 0.06, "mass": 0.08}
"""Prior standard deviations of a pattern's shifts of log drag and log thrust, and of relative mass. [1]"""
SMOOTH_LENGTH = 1.0
"""Correlation length of a smooth pattern, in standard deviations of its number. [1]"""
NEGLIGIBLE_VARIANCE = 0.03
"""Components of a smooth pattern below this fraction of its variance are left out. [1]"""
MAX_COMPONENTS = 4
"""Maximum number of components of a smooth pattern. [1]"""
MOST_VALUES = 6
"""A column of the flyer's table with at most this many different texts defines groups of flights. [1]"""


def pattern_candidates(model: Model) -> list[Candidate]:
    """Patterns in thrust, drag and mass that no effect explains, each kind with the same odds."""
    kinds = known_patterns(model.flights)
    return [
        Candidate(
            Place(pattern=pattern),
            _pattern_terms(pattern, weigh(model.flights)),
            log_fraction=float(-np.log(len(kind) * len(kinds))),
        )
        for kind in kinds
        for pattern, weigh in kind.items()
    ]


def pattern_terms(place: Place, model: Model) -> tuple[Term, ...]:
    """A pattern found in a model's flown flights, as terms of all its flights; none if they do not show it."""
    for kind in known_patterns(model.flights[: model.history.flown]):
        if place.pattern and place.pattern in kind:
            return _pattern_terms(place.pattern, _weighed(kind[place.pattern], model.history))
    return ()


def _weighed(weigh: Weigh, history: History) -> Array:
    """The weight of a pattern on the flown flights, and on each plan at its place, as if the earlier plans were like
    it."""
    flights, flown = history.flights, history.flown
    past, planned = flights[:flown], zip(flights[flown:], history.flight_index[flown:], strict=True)
    ahead = [weigh([*past[:turn], *[plan] * (max(turn - flown, 0) + 1)])[-1] for plan, turn in planned]
    return np.concatenate([weigh(past), np.array(ahead)]) if ahead else weigh(past)


def known_patterns(flights: Sequence[Flight]) -> list[PatternKind]:
    """Patterns that flights may have in common: single days, the hour, a lasting change between two flights, every
    second or third flight, a site, a recorded condition, and other columns of the flyer's table that were known before
    lift-off (`fieldkit.selection.covariates`)."""
    return [kind for kind in (*_in_time(flights), *_in_columns(flights)) if kind] if flights else []


def _in_time(flights: Sequence[Flight]) -> Iterator[PatternKind]:
    """Patterns in the order and hours of flights."""
    yield {Pattern("day", day): _same(_days, day) for day in _shared(_days(flights))}
    known = hours(flights)
    if np.isfinite(known).all() and known.std() > 1:
        middle = known.mean()
        yield {
            Pattern("hour"): lambda some: np.nan_to_num((hours(some) - middle) / 4),
            Pattern("hour", smooth=True): _smooth(hours, known),
        }
    if len(flights) >= 8:
        yield {Pattern("count", smooth=True): _smooth(_number_flown, _number_flown(flights))}
    yield {Pattern("lasting", flights[k].flight_id): _from(k) for k in range(3, len(flights) - 2)}
    if len(flights) >= 8:
        flight_index = [(n, k) for n in (2, 3) for k in range(n - (n == 2))]
        yield {Pattern("repeated", flights[k].flight_id, every=n): _every(n, k) for n, k in flight_index}


def _in_columns(flights: Sequence[Flight]) -> Iterator[PatternKind]:
    """Patterns that correlate with recorded conditions and columns; the effects on motors act on their lots."""
    yield {Pattern("site", site): _same(_sites, site) for site in _shared(_sites(flights))}
    measured: dict[str, Weigh] = {name: partial(_recorded, name) for name in ("temperature", "humidity", "pressure")}
    for name in headers(flights):
        if names_a_lot(name) or not known_before(name, flights):
            continue
        own = _texts(name, flights)
        if len(set(own)) > MOST_VALUES:
            measured[name] = partial(own_numbers, name)
        elif len(set(own)) > 1:
            yield {Pattern("text", name, value): _same(partial(_texts, name), value) for value in _shared(own)}
    for name, read in measured.items():
        column = read(flights)
        if np.isfinite(column).all() and np.ptp(column) > 0:
            yield {
                Pattern("number", name): _standard(read, float(column.mean()), float(column.std())),
                Pattern("number", name, smooth=True): _smooth(read, column),
            }


def _shared(labels: Sequence[str]) -> list[str]:
    """Labels that at least two flights have and at least two do not."""
    return [label for label in dict.fromkeys(labels) if label and 2 <= labels.count(label) <= len(labels) - 2]


def _same(labels: Callable[[Sequence[Flight]], Sequence[str]], value: str) -> Weigh:
    return lambda some: np.array([label == value for label in labels(some)], float)


def _from(first: int) -> Weigh:
    return lambda some: np.where(np.arange(len(some)) >= first, 1.0, 0.0)


def _every(n: int, first: int) -> Weigh:
    return lambda some: np.where(np.arange(len(some)) % n == first, 1.0, 0.0)


def _standard(read: Weigh, mean: float, sd: float) -> Weigh:
    """A column minus its mean; zero for flights without a value."""
    return lambda some: np.nan_to_num((read(some) - mean) / sd)


def _smooth(read: Weigh, column: Float[Array, "flown"]) -> Weigh:
    """A Gaussian process of a number with unit variance, expressed by its components at the flown flights."""
    middle, spread = float(column.mean()), float(column.std()) or 1.0

    def kernel(one: Array, other: Array) -> Array:
        distance = (one[:, None] - other) / (SMOOTH_LENGTH * spread)
        return np.asarray(np.exp(-0.5 * distance**2))

    variance, shape = np.linalg.eigh(kernel(column, column))
    kept = np.flatnonzero(variance > NEGLIGIBLE_VARIANCE * len(column))[-MAX_COMPONENTS:]
    loading = shape[:, kept] / np.sqrt(variance[kept])
    return lambda some: kernel(np.nan_to_num(read(some), nan=middle), column) @ loading


def _number_flown(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    return np.arange(float(len(flights)))


def _recorded(name: str, flights: Sequence[Flight]) -> Float[Array, "flight"]:
    return recorded(flights, name)


def _texts(name: str, flights: Sequence[Flight]) -> list[str]:
    return [flight.text(name) for flight in flights]


def _days(flights: Sequence[Flight]) -> list[str]:
    return [flight.date_time.date().isoformat() if flight.date_time else "" for flight in flights]


def _sites(flights: Sequence[Flight]) -> list[str]:
    return [flight.site for flight in flights]


def hours(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """The hour of the day of each flight; nan without a time, which is recorded as midnight. [h]"""
    times = [flight.date_time.time() if flight.date_time else time() for flight in flights]
    return np.array([at.hour + at.minute / 60 if at != time() else np.nan for at in times])


def _pattern_terms(pattern: Pattern, weight: Array) -> tuple[Term, ...]:
    """Terms for a change in drag, thrust and mass; only drag for a smooth pattern."""
    if weight.ndim == 2:
        return tuple(
            Term(TermName(f"drag {number}", "pattern", pattern), "drag", 0.0, PATTERN_DRAG_SD, weight[:, number])
            for number in range(weight.shape[1])
        )
    return tuple(Term(TermName(bends, "pattern", pattern), bends, 0.0, sd, weight) for bends, sd in PATTERN_SDS.items())
