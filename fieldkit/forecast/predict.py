"""The distribution of the next flight: simulations with draws from the posterior of a rocket's model.

Shared terms are drawn from the posterior, scatter and reading errors separately for every flight, and all draws are
simulated in one batch. Without flights the priors are simulated, and the prediction reports that. A forecast does not
depend on the other plans in the request: each uses the same draws as alone.
"""

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import FLIGHTS_ALONE, Assumed
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.prediction import Prediction
from fieldkit.forecast.term_draws import term_draws
from fieldkit.inference.laplace.few_flights import with_and_without_one_off
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.leave_one_out import own_reading_sd
from fieldkit.inference.laplace.outliers import outlier_lines
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import Data, observe
from fieldkit.model.rocket_model import Model, apogee_scatter
from fieldkit.model.simulated_readouts import EXTRAS, bent, shown
from fieldkit.motors import Found
from fieldkit.motors.delay_tolerance import log_delay_ratio
from fieldkit.physics.effect import spoken
from fieldkit.physics.history import History, flown_and_planned
from fieldkit.selection.candidates import Place
from fieldkit.shapes import Array, Float

DRAWS = 1000
"""Number of simulations for each prediction; the error of a 5% quantile is about a tenth of the standard deviation."""
MAX_LOG_APOGEE_RATIO = 1.5
"""Limit of the log ratio of an apogee to its expectation in a draw, because the tail of a Student t has no physical
bound. [1]"""


def model_name(accepted: Sequence[Place]) -> str:
    """`field`, `field+wind`, or `field+unexplained`."""
    return "+".join(["field", *(spoken(place.effect) or "unexplained" for place in accepted)])


Fits = dict[Hashable, Fit]
"""Fits of one rocket's flights by what their models have in common and what not: all but the flights."""


@dataclass(frozen=True, slots=True)
class FittedForecast:
    """Posterior draws of every term for the simulation of planned flights.

    `model` is the model of the planned flights, and `at` the center of the posterior. `rests_on` counts the flights in
    the fit, `heaviest_motor` is the largest loaded mass of a motor flown so far [kg], and `name` the model's name;
    `rng` draws the scatter of single flights. `left_out` is as in `Prediction`.
    """

    model: Model
    at: Float[Array, "term"]
    values: Float[Array, "draw term"]
    scales: Float[Array, "draw 3"]
    rests_on: int
    heaviest_motor: float
    name: str
    rng: np.random.Generator
    left_out: tuple[str, ...] = ()


def predict(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]],
    assumed: Assumed = FLIGHTS_ALONE,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    fits: Fits | None = None,
) -> list[Prediction]:
    """Predict planned flights of one rocket from its flights in the order flown.

    The plans are flown one after the other, which matters only to effects that grow from flight to flight. Flights with
    an anomaly tag count as flown and are not used in the fit; outliers have little weight. `fits` are fits of the same
    flights, with the same design and other rockets, to be used and added to. Raises ImpossibleFlight for a flight
    without a dry mass, DamagedModel if the learned hyperprior cannot be read.
    """

    def predict_rows(rows: Sequence[int]) -> list[Prediction]:
        history = flown_and_planned(flown, [planned[row] for row in rows], [len(flown) + row for row in rows])
        return fly_ahead(learn(history, assumed, draws=draws, seed=seed, fits=fits), paired=True)

    return by_kind(flown, planned, predict_rows)


def learn(
    history: History, assumed: Assumed = FLIGHTS_ALONE, *, draws: int = DRAWS, seed: int = 0, fits: Fits | None = None
) -> FittedForecast:
    """Fit the flown flights of a history for its plans, which are of one kind (see `fieldkit.forecast.kinds`). Other
    arguments and errors as in `predict`."""
    flown, acting = history.flown, assumed.acting(history.flights)
    every = tuple(dict.fromkeys(place for _, own in acting for place in own))
    model = assumed.model(history, every)
    data = observe(history, model.hyperprior)
    rng, fits = np.random.default_rng(seed), {} if fits is None else fits
    parts = []
    for (_, own), count in zip(acting, _allotted([chance for chance, _ in acting], draws), strict=True):
        if count:
            terms = _terms_without(model, set(every) - set(own))
            parts.append(_drawn_with(model, terms, data, count, rng, fits))
    values, scales = (np.concatenate(column) for column in zip(*((v, s) for _, v, s, _ in parts), strict=True))
    return FittedForecast(
        model=model.part(slice(flown, None)),
        at=parts[0][0],
        values=values,
        scales=scales,
        rests_on=int(np.sum(data.seen.any(axis=1))),
        heaviest_motor=max((found.motor.loaded_mass for found in history.found[:flown]), default=0.0),
        name=model_name(assumed.sets[0][1] if assumed.sets else ()),
        rng=rng,
        left_out=parts[0][3],
    )


def fitted(model: Model, data: Data, fits: Fits) -> Fit:
    """The fit of flown flights, from `fits` if it is there, otherwise added to them, in little memory."""
    key = tuple((term.name[:2], term.bends, term.mean, term.sd, *term.weight) for term in model.terms)
    if (known := fits.get(key)) is None:
        known = fit_robustly(replace(model, coarse=True), data, causes=True)
        fits[key] = known.unsolved()
    return known


def _allotted(chances: Sequence[float], draws: int) -> list[int]:
    """Number of draws of each component of a mixture, in proportion to their probabilities after rounding, summing to
    all draws."""
    ends = np.round(np.cumsum(chances) / np.sum(chances) * draws).astype(int)
    return [int(count) for count in np.diff(ends, prepend=0)]


def _terms_without(model: Model, places: Collection[Place]) -> list[int]:
    """The terms of a model except those of some effects in their places."""
    return [i for i, term in enumerate(model.terms) if not any(place.has(term.name) for place in places)]


def _drawn_with(
    model: Model,
    terms: Sequence[int],
    data: Data,
    draws: int,
    rng: np.random.Generator,
    fits: Fits,
) -> tuple[Float[Array, "term"], Float[Array, "draw term"], Float[Array, "draw 3"], tuple[str, ...]]:
    """The final point of a fit of some of a model's terms, draws of every term (zero for terms it lacks) and of the
    scales, and a line for each outlier. `fits` are the fits so far: what acts only ahead does not change them."""
    part, flown = model.only(terms), model.history.flown
    known = set(part.shared.names) if part.shared else set()
    acted = [i for i, term in enumerate(part.terms) if term.name in known or np.any(term.weight[:flown] != 0)]
    used = acted or [0]  # a rocket never flown has the prior instead of a fit
    result = fitted(part.part(slice(0, len(data.seen))).only(used), data, fits)
    part = replace(part, hyperprior=result.model.hyperprior)
    cases = with_and_without_one_off(result)
    counts = _allotted([chance for chance, _ in cases], draws)
    drawn = [
        term_draws(part, used, fit, count, rng, again=bool(flown))
        for (_, fit), count in zip(cases, counts, strict=True)
        if count
    ]
    own, scales = (np.concatenate(column) for column in zip(*drawn, strict=True))
    values, at = np.zeros((draws, len(model.terms))), np.zeros(len(model.terms))
    values[:, terms] = own
    ends = np.array([term.mean for term in part.terms])
    ends[used] = result.tangent.at
    at[list(terms)] = ends
    return at, values, scales, outlier_lines(result) if flown else ()


def fly_ahead(fitted: FittedForecast, *, paired: bool = False) -> list[Prediction]:
    """Simulate the planned flights with the posterior draws, one batch of draws per flight.

    With `paired`, all flights share random draws, so that they differ only by their plans. Delays scatter within the
    tolerance of makers (`fieldkit.motors.delay_tolerance`), whatever the scatter of the rocket. Raises ImpossibleFlight
    for a flight without a dry mass.
    """
    part, values, rng = fitted.model, fitted.values, fitted.rng
    scale = {"scatter": fitted.scales[:, :1], "motors": fitted.scales[:, 2:], "": np.ones((len(values), 1))}
    shape = (len(values), len(part.flights))

    def draw(rng: np.random.Generator = rng) -> Array:
        drawn = rng.normal(size=(shape[0], 1) if paired else shape)
        return np.broadcast_to(drawn, shape)

    def tailed() -> Array:
        """Student t, as every residual of the model."""
        freedom = part.hyperprior.tail
        mixed = np.sqrt(freedom / rng.chisquare(freedom, (shape[0], 1) if paired else shape))
        return np.broadcast_to(draw() * mixed, shape)

    kinds = {kind.bends: kind.sd for kind in part.scatter}
    (weather,) = rng.spawn(1)  # of its own, so that uncertain weather leaves the other draws as they are
    own_rng = dict.fromkeys(part.history.uncertain, weather)
    normal = {name: draw(own_rng.get(name, rng)) for name in (*kinds, *({"delay"} - set(kinds)))}
    scatter: dict[str, Array] = {
        name: normal[name] * sd * scale[part.hyperprior.scale_of(name)] for name, sd in kinds.items()
    }
    scatter["delay"] = log_delay_ratio(part.history.delays, normal["delay"])
    readings = shown(part, values, scatter)
    # for an apogee of about a meter the relative reading error is unbounded
    own = np.clip(tailed() * apogee_scatter(part) * scale["scatter"], -MAX_LOG_APOGEE_RATIO, MAX_LOG_APOGEE_RATIO)
    higher = np.exp(own)
    apogee = readings["apogee"] * higher
    reading = np.clip(own_reading_sd(apogee, part.hyperprior) * draw(), -1.0, 1.0)
    figures = {
        "apogee": np.nan_to_num(apogee * np.exp(reading)),
        "true_apogee": np.nan_to_num(readings["true"] * higher),
        "eject": readings["apogee_to_eject"],
        "coast": readings["coast_to_apogee"],
        "cd": np.exp(bent(part, values, "drag") + scatter.get("drag", 0.0)),
        "alpha": np.exp(bent(part, values, "thrust") + scatter.get("thrust", 0.0)),
        **{name: readings[name] for name in ("top_speed", "duration", *EXTRAS)},
    }
    return [
        Prediction(
            plan=flight,
            found=motor,
            rests_on=fitted.rests_on,
            heaviest_motor=fitted.heaviest_motor,
            model=fitted.name,
            left_out=fitted.left_out,
            random_draws=tuple(drawn[:, i] for drawn in (*scatter.values(), own, reading)),
            **{name: values[:, i] for name, values in figures.items()},  # every field is an array of draws
        )
        for i, (flight, motor) in enumerate(zip(part.flights, part.found, strict=True))
    ]
