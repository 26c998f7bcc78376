"""Forecasts of plans, with the drag and thrust behind them, from one linear pass over a rocket's flights.

The pass has the model of forecasts. It answers before a fit does: derivatives of simulations at three drag coefficients
replace the simulations of a fit, and the scales of scatter are a few values, over which the forecast is a mixture.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.inference.history.linear_fit import (
    LinearFit,
    PreparedFit,
    history_model,
    linear_fit,
    prepared_fit,
    robust,
    usual_mean,
)
from fieldkit.inference.history.moments import (
    FORECAST_READOUTS,
    apogee_mixture,
    mixed_apogees,
    mixed_moments,
    mixed_readouts,
    moments,
    readout_moments,
)
from fieldkit.inference.history.response import FlightResponse, off_reference, reference, respond
from fieldkit.inference.history.usual_flights import Cases, with_one_offs
from fieldkit.model.documents import with_documents
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, Data, as_compared, readings
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.effect import Effect
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float

MODEL = "field"
"""The name of the model behind a quick answer, as in a forecast of the fit."""
NORMAL_95 = 1.6448536
"""The 95% quantile of the standard normal distribution. [1]"""


@dataclass(frozen=True, slots=True)
class QuickAnswer:
    """The answer of a linear pass for one plan of a history, provisional until a fit has checked it.

    `apogees` are equally likely apogees of the plan in ascending order [m]; `log_cd` and `log_alpha` are mean and
    standard deviation, and `correlation` is the correlation of the two [1]. `readouts` are the 5, 50 and 95% quantiles
    of the plan's other readouts, without reading errors, in SI. `cases` are the linear fits behind the answer with
    their probabilities [1], and `plan` is the number of the plan in the history.
    """

    apogees: Float[Array, "draw"]
    log_cd: tuple[float, float]
    log_alpha: tuple[float, float]
    correlation: float
    readouts: Mapping[str, tuple[float, float, float]]
    cases: Cases
    data: Data
    plan: int = 0

    @property
    def linear(self) -> LinearFit:
        """The fit to all flights, all or each to the degree that it is a usual one."""
        return self.cases[0][1]

    def apogee_at(self, level: float) -> float:
        """A quantile of the plan's apogee. [m]"""
        return float(np.quantile(self.apogees, level))

    @property
    def rests_on(self) -> int:
        """Number of flights that the answer uses. [1]"""
        return int(self.data.seen.any(axis=1).sum())


@dataclass(frozen=True, slots=True, eq=False)
class PreparedHistory:
    """The part of a history that does not change while readouts are typed: its model, and the response of its flights
    around the values `center` of the model's terms, in their units."""

    history: History
    fit: PreparedFit
    response: FlightResponse
    center: Float[Array, "term"]

    @property
    def flown(self) -> tuple[Flight, ...]:
        """The flown flights, as they were when this was prepared."""
        return self.history.flights[: self.history.flown]


def modeled(history: History, shared: SharedPrior | None = None) -> PreparedFit:
    """The forecast model of a rocket's history and one planned flight, or several alternative plans that differ only in
    their motors; either all or none of the plans use motors flown before. `shared` is the information from the flyer's
    other rockets. Raises ImpossibleFlight for a flight without a dry mass, DamagedModel if the hyperprior cannot be
    read.
    """
    return prepared_fit(history_model(history, with_documents(learned()), shared, declared=True), history.flown)


def acting(fit: PreparedFit) -> frozenset[str]:
    """The effects whose response a fit needs."""
    every = (*fit.model.terms, *fit.fresh)
    return frozenset(term.name.quantity for term in every if isinstance(term.bends, Effect))


def around_reference(history: History, shared: SharedPrior | None = None) -> PreparedHistory:
    """A history simulated around the reference, for a first pass; arguments and errors as in `modeled`."""
    fit = modeled(history, shared)
    return PreparedHistory(history, fit, respond(history, acting(fit)), reference(fit.model))


def prepared(history: History, shared: SharedPrior | None = None) -> PreparedHistory:
    """The part of a history that does not depend on the readouts typed since. Arguments and errors as in `modeled`."""
    return centered(around_reference(history, shared))


def centered(first: PreparedHistory) -> PreparedHistory:
    """A history linear around the posterior means of a first pass. Raises ImpossibleFlight for a flight without a dry
    mass."""
    model, center = first.fit.model, posterior_center(first)
    response = respond(first.history, acting(first.fit), off_reference(model, center))
    return replace(first, response=response, center=center)


def posterior_center(first: PreparedHistory) -> Float[Array, "term"]:
    """The posterior means of the terms that act on inputs of flown flights, and the reference values of the others, in
    their units. Derivation: a Gauss-Newton step moves the point of linearization to the posterior mean."""
    model, flown = first.fit.model, first.fit.flown
    mean = usual_mean(first.fit, _data(first, first.flown), first.response, first.center)
    moved = [
        isinstance(term.bends, str) and term.bends not in OBSERVED_READOUTS and bool(term.weight[:flown].any())
        for term in model.terms
    ]
    return np.where(moved, mean, reference(model))


def answers(ready: PreparedHistory, flown: Sequence[Flight], *, causes: bool = True) -> list[QuickAnswer]:
    """The answer for each plan of a history, with the current readouts of its flown flights. Without `causes`, all are
    taken for usual flights of the rocket. Raises ImpossibleFlight for a flight without a dry mass.
    """
    data = _data(ready, flown)
    linear = robust(linear_fit(ready.fit, data, ready.response, center=ready.center))
    cases = with_one_offs(linear) if causes else [(1.0, linear)]
    found = mixed_moments([(chance, moments(one)) for chance, one in cases])
    mixture = mixed_apogees([(chance, apogee_mixture(one)) for chance, one in cases])
    readouts = _readouts(cases)
    return [
        QuickAnswer(
            mixture.apogees(plan),
            (float(found.cd[plan]), float(found.cd_sd[plan])),
            (float(found.alpha[plan]), float(found.alpha_sd[plan])),
            float(found.correlation[plan]),
            readouts[plan],
            tuple(cases),
            data,
            plan,
        )
        for plan in range(len(found.cd))
    ]


def _data(ready: PreparedHistory, flown: Sequence[Flight]) -> Data:
    """The readouts of the flown flights; those of unchanged ones are read once."""
    history, before = ready.history, ready.flown
    read = ready.fit.model.once("readings", lambda: readings(before, history.found[: len(before)]))
    if rows := [row for row, (now, then) in enumerate(zip(flown, before, strict=True)) if now is not then]:
        read = read.changed(rows, readings([flown[row] for row in rows], [history.found[row] for row in rows]))
    return as_compared(read, history.used_in_fit, ready.fit.model.hyperprior)


def _readouts(cases: Cases) -> list[dict[str, tuple[float, float, float]]]:
    """For each plan, the quantiles in SI of readouts that are normal in the form that is compared; a readout that the
    plan lacks is left out."""
    found = mixed_readouts([(chance, readout_moments(one)) for chance, one in cases])
    logarithmic = [bool(IS_LOGARITHMIC[OBSERVED_READOUTS.index(name)]) for name in FORECAST_READOUTS]
    ends = found.mean[..., None] + found.sd[..., None] * np.array([-NORMAL_95, 0.0, NORMAL_95])
    ends[:, logarithmic] = np.exp(ends[:, logarithmic])
    known = np.isfinite(ends).all(axis=-1).tolist()
    return [
        {
            name: (low, middle, high)
            for name, (low, middle, high), shown in zip(FORECAST_READOUTS, own, has, strict=True)
            if shown
        }
        for own, has in zip(ends.tolist(), known, strict=True)
    ]
