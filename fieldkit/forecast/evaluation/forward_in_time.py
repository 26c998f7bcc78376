"""Forecasts forward in time: each flight of a ledger is forecast from the earlier flights of all its rockets.

Source: prequential evaluation (Dawid, Statistical Theory: The Prequential Approach, 1984).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date, datetime

from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.conformal import stretch, stretched, surprise
from fieldkit.forecast.evaluation.rivals import MIXTURE, rival_draws
from fieldkit.forecast.evaluation.stacking import STACKED_RIVALS, ScoredForecast, log_scores, mixed_in, weights_after
from fieldkit.forecast.evaluation.uncalibrated import Simulated, simulate
from fieldkit.forecast.predict import predict
from fieldkit.forecast.prediction import LEVELS, quantiles
from fieldkit.inference.laplace.fleet import RocketFit, rocket_fit, shared_prior
from fieldkit.model.fleet_drift import period_of
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.progress import ReportProgress, no_op
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Forecast:
    """One flight with the forecasts of the model and its rivals from before the flight. [m]

    `draws` are the model's equally likely apogees and `p05` to `p95` its quantiles; `rivals` are the draws of the
    rivals with enough data, and `stacked` is the mixture with those of them that did better on earlier flights.
    `log_scores` are the log densities of the flight in the forecasts that can be mixed. [nat] `earlier` counts the
    earlier clean flights with an apogee of its rocket. `corrected` is the 90% interval after `corrected_by_earlier`, by
    a factor `stretch`; both are None if there are too few earlier forecasts.
    """

    rocket: str
    flight_id: str
    motor: str
    earlier: int
    flown: float
    p05: float
    p50: float
    p95: float
    draws: Float[Array, "draw"] = field(repr=False, compare=False)
    rivals: Mapping[str, Float[Array, "_"]] = field(default_factory=dict, repr=False, compare=False)
    when: datetime | None = None
    stretch: float | None = None
    corrected: tuple[float, float] | None = None
    log_scores: tuple[float, ...] = ()

    @property
    def scored(self) -> ScoredForecast:
        """The scores of the forecasts that can be mixed."""
        return ScoredForecast(not self.earlier, self.log_scores)

    @property
    def interval(self) -> tuple[float, float, float]:
        """The model's 5, 50 and 95% quantiles. [m]"""
        return self.p05, self.p50, self.p95

    @property
    def issued(self) -> tuple[float, float, float]:
        """The 5, 50 and 95% quantiles of the mixture, or of the model without one, before the correction. [m]"""
        if MIXTURE not in self.rivals:
            return self.interval
        low, middle, high = quantiles(self.rivals[MIXTURE], LEVELS).tolist()
        return low, middle, high


def forward(
    flown: Sequence[FlownFlight],
    rocket: str | None = None,
    *,
    hyperprior: Hyperprior | None = None,
    since: date | None = None,
    on_progress: ReportProgress = no_op,
) -> list[Forecast]:
    """A forecast of every clean flight with an apogee, from the flights of all rockets before it in the order flown.

    With `rocket`, only flights of that rocket are forecast, still from the flights of all. The message of a rocket to
    the fleet is updated after each of its flights. `hyperprior` replaces the learned one. Flights before the day
    `since` are not forecast. Raises ImpossibleFlight for a flight without a dry mass, DamagedModel if the learned
    hyperprior cannot be read.
    """
    known = hyperprior or learned()
    past: dict[str, list[FlownFlight]] = {}
    fits: dict[str, tuple[int, RocketFit]] = {}
    earlier: list[Simulated] = []
    rows: list[Forecast] = []
    for number, one in enumerate(simulate(flown)):
        own = past.setdefault(one.flight.rocket, [])
        if one.flight.clean and one.flight.apogee is not None:
            when = one.flight.date_time
            if rocket in (None, one.flight.rocket) and not (since and when and when.date() < since):
                on_progress(f"{one.flight.rocket} {one.flight.flight_id}", number / len(flown))
                shared = _fleet_before(one.flight.rocket, past, fits, known)
                rows.append(_forecast(own, one, earlier, shared, hyperprior))
            earlier.append(one)
        own.append((one.flight, one.found))
    return rows


def _fleet_before(
    rocket: str,
    past: Mapping[str, Sequence[FlownFlight]],
    fits: dict[str, tuple[int, RocketFit]],
    hyperprior: Hyperprior,
) -> SharedPrior | None:
    """The information from all other rockets' flights so far; `fits` has the fits of rockets that have not flown
    since."""
    found = []
    period = period_of(flight for flown in past.values() for flight, _ in flown)
    for name, flown in past.items():
        teaching = [(flight, motor) for flight, motor in flown if flight.clean and flight.readouts()]
        if name == rocket or not teaching:
            continue
        if name not in fits or fits[name][0] != len(teaching):
            fits[name] = len(teaching), rocket_fit(teaching, hyperprior, period)
        found.append(fits[name][1])
    return shared_prior(found, period)


def _forecast(
    past: Sequence[FlownFlight],
    plan: Simulated,
    earlier: Sequence[Simulated],
    shared: SharedPrior | None,
    hyperprior: Hyperprior | None,
) -> Forecast:
    """One flight with its forecasts."""
    (made,) = predict(past, [(plan.flight.unflown(), plan.found)], Assumed(shared=shared, hyperprior=hyperprior))
    return beside_rivals(plan, made.apogee, made.apogee_quantiles(), earlier)


def beside_rivals(
    plan: Simulated,
    draws: Float[Array, "draw"],
    interval: tuple[float, float, float],
    earlier: Sequence[Simulated],
) -> Forecast:
    """A flight, simulated as planned, with its forecast and the rivals' forecasts from earlier flights; draws of the
    apogee and its 90% interval with the median [m]."""
    flight = plan.flight
    assert flight.apogee is not None
    return Forecast(
        flight.rocket,
        flight.flight_id,
        flight.motor,
        sum(one.flight.rocket == flight.rocket for one in earlier),
        flight.apogee,
        *interval,
        draws=draws,
        rivals=rival_draws(earlier, plan),
        when=flight.date_time,
    )


def with_stacked(rows: Sequence[Forecast]) -> list[Forecast]:
    """The forecasts in the order flown, each with its stacked mixture, weighted by the forecasts of earlier flights."""
    found: list[Forecast] = []
    for row in rows:
        weights = weights_after((one.scored for one in found), first=not row.earlier)
        mixture = mixed_in(row.draws, row.rivals, weights)
        scores = log_scores(row.draws, row.rivals, row.flown)
        found.append(replace(row, rivals={**row.rivals, MIXTURE: mixture}, log_scores=scores))
    return found


def next_weights(rows: Sequence[Forecast], *, first: bool = False) -> dict[str, float]:
    """The stacking weights for the next flight, of a rocket that has flown or its first, by method, from the result of
    `with_stacked`. [1]"""
    weights = weights_after((row.scored for row in rows), first=first)
    return dict(zip(("fieldkit", *STACKED_RIVALS), weights, strict=True))


def corrected_by_earlier(rows: Sequence[Forecast]) -> list[Forecast]:
    """The forecasts in the order flown, each with its issued interval corrected by the results of earlier flights.

    The correction uses the forecasts of all rockets given, because one rocket rarely has enough.
    """
    found: list[Forecast] = []
    surprises: list[float] = []
    for row in rows:
        by = stretch(surprises)
        if by is not None:
            low, _, high = stretched(row.issued, by)
            row = replace(row, stretch=by, corrected=(low, high))
        found.append(row)
        surprises.append(surprise(row.flown, row.issued))
    return found


def corrected_coverage(rows: Sequence[Forecast]) -> dict[str, float | None] | None:
    """Coverage of the corrected intervals, of the uncorrected ones for the same flights, the number of these flights
    and the factor of the last one; None if no interval was corrected. [1]"""
    later = [(row, row.corrected) for row in rows if row.corrected]
    if not later:
        return None
    inside = [low <= row.flown <= high for row, (low, high) in later]
    own = [row.issued[0] <= row.flown <= row.issued[2] for row, _ in later]
    coverage = {"coverage90": sum(inside) / len(later), "own_coverage90": sum(own) / len(later)}
    return {"flights": len(later), **coverage, "last_stretch": later[-1][0].stretch}
