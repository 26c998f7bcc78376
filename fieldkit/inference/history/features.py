"""The features of the history network: evidence, forecasts and residuals of linear fits, in the same order for any
history and independent of the order in which a day's flights are listed.

They come from two fits: one with the hyperprior for effects, one with the hyperprior for forecasts. In the evidence for
effects, outliers have smaller weights, as in the loop.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.inference.history.columns import (
    OF_HISTORY,
    PER_EFFECT,
    odds_of,
    of_effects,
    of_evidence,
    of_history,
    ranked,
)
from fieldkit.inference.history.evidence import Trials, weigh_placed
from fieldkit.inference.history.linear_fit import (
    LinearFit,
    PreparedFit,
    history_data,
    history_model,
    linear_fit,
    on_one_new_motor,
    prepared_fit,
    robust,
)
from fieldkit.inference.history.moments import Moments, moments
from fieldkit.inference.history.placed_effects import Candidates, Placed, PlacedEffect, directions
from fieldkit.inference.history.response import FlightResponse
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut, leave_one_out
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.readout_data import Data, readings
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.effect import Effect, effects, spoken
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class HistorySummary:
    """The features of a history, one row per plan, and their linear fits. `baseline` are the forecasts that the network
    corrects."""

    features: Float[Array, "plan feature"]
    baseline: Moments
    selection: LinearFit
    forecast: LinearFit
    trials: Trials
    candidates: tuple[PlacedEffect, ...]
    data: Data
    left_out: LeaveOneOut


def effect_names() -> tuple[str, ...]:
    """The effects that verdicts name, in alphabetical order."""
    return tuple(sorted({spoken(name) for name in effects()}))


def feature_names(names: Sequence[str]) -> tuple[str, ...]:
    """The names of the features for some effects: first the history's, then each effect's."""
    return (*OF_HISTORY, *(f"{effect}.{name}" for effect in names for name in PER_EFFECT))


@dataclass(frozen=True, slots=True, eq=False)
class ModeledHistory:
    """A history with the part of its fits that does not depend on readouts, with both hyperpriors, and the candidates,
    also as directions."""

    history: History
    selection: PreparedFit
    forecast: PreparedFit
    candidates: tuple[PlacedEffect, ...]
    placed: Placed

    @property
    def flown(self) -> tuple[Flight, ...]:
        """The flown flights, as they were when this was made."""
        return self.history.flights[: self.history.flown]

    @property
    def acting(self) -> frozenset[str]:
        """The effects whose response it needs."""
        every = [term for fit in (self.selection, self.forecast) for term in (*fit.model.terms, *fit.fresh)]
        every += [term for candidate in self.candidates for term in candidate.terms]
        return frozenset(term.name.quantity for term in every if isinstance(term.bends, Effect))


@dataclass(frozen=True, slots=True, eq=False)
class PreparedHistory:
    """The part of a history that does not change while readouts are typed: its models, and the response of its
    flights."""

    modeled: ModeledHistory
    response: FlightResponse

    @property
    def flown(self) -> tuple[Flight, ...]:
        """The flown flights, as they were when this was prepared."""
        return self.modeled.flown


def modeled(
    history: History,
    candidates_of: Candidates,
    shared: SharedPrior | None = None,
    forecast: Hyperprior | None = None,
) -> ModeledHistory:
    """The models of a rocket's history and one planned flight, or several alternative plans that differ only in their
    motors; either all or none of the plans use motors flown before. `shared` is the information from the flyer's other
    rockets, and `forecast` the hyperprior for forecasts, by default the learned one.
    Raises ImpossibleFlight for a flight without a dry mass, DamagedModel if the hyperprior cannot be read.
    """
    count = history.flown
    model = history_model(history, CERTIFIED_PRIOR, declared=False)
    ahead = history_model(history, forecast or learned(), shared, declared=True)
    # an effect of a motor is equally probable for each new one
    candidates = tuple(candidates_of(replace(model, history=on_one_new_motor(history))))
    return ModeledHistory(
        history, prepared_fit(model, count), prepared_fit(ahead, count), candidates, directions(candidates)
    )


def summarized(ready: PreparedHistory, flown: Sequence[Flight], names: Sequence[str]) -> HistorySummary:
    """The features of a history with the current readouts of its flown flights."""
    own, response = ready.modeled, ready.response
    history, candidates = own.history, own.candidates
    read = readings(flown, history.found[: len(flown)])
    data = history_data(read, history.used_in_fit, own.selection.model.hyperprior)
    selection = linear_fit(own.selection, data, response)
    trials = weigh_placed(robust(selection), own.placed)
    forecast_data = history_data(read, history.used_in_fit, own.forecast.model.hyperprior)
    plain = linear_fit(own.forecast, forecast_data, response, start=selection.offset, rounds=1)
    robustly = robust(plain)
    beside_forecast = weigh_placed(plain, own.placed)
    baseline, unrobust = moments(robustly), moments(plain)
    left_out = leave_one_out(selection.fit)
    columns = of_history(history, selection, plain, robustly, data, left_out)
    by_evidence = ranked(trials)
    odds = odds_of(by_evidence)
    columns |= of_evidence(by_evidence, beside_forecast, odds)
    columns |= {
        "forecast_sd": np.log(baseline.apogee_sd),
        "parameter_sd": np.log(baseline.parameter_sd),
        "robust_shift": (unrobust.apogee - baseline.apogee) / baseline.apogee_sd,
        "shift": columns["shift"] / baseline.apogee_sd,
        "shift_sd": columns["shift_sd"] / baseline.apogee_sd,
        "shift_of_first": columns["shift_of_first"] / baseline.apogee_sd,
        "cd_sd": np.log(baseline.cd_sd),
        "alpha_sd": np.log(baseline.alpha_sd),
        "cd_alpha": baseline.correlation,
    }
    values = [columns[name] for name in OF_HISTORY]
    whole = np.empty((len(baseline.apogee), len(values) + len(names) * len(PER_EFFECT)))
    for column, value in enumerate(values):
        whole[:, column] = value
    whole[:, len(values) :] = of_effects(by_evidence, beside_forecast, odds, names).ravel()
    features = np.clip(np.nan_to_num(whole, nan=0.0, posinf=20.0, neginf=-20.0), -20.0, 20.0)
    return HistorySummary(features, baseline, selection, robustly, trials, candidates, data, left_out)
