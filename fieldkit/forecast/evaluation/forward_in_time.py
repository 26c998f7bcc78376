"""Forecasts forward in time: each flight of a ledger forecast from what all its rockets had flown before it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime

from fieldkit.flight import Flight
from fieldkit.forecast.conformal import stretch, stretched, surprise
from fieldkit.forecast.evaluation.rivals import rival_draws
from fieldkit.forecast.evaluation.stacking import STACKED_RIVALS, log_scores, mixed_in, weights_after
from fieldkit.forecast.evaluation.uncalibrated import Simulated, simulate
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.fleet import RocketFit, rocket_fit, shared_prior
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found
from fieldkit.progress import ReportProgress, no_op
from fieldkit.shapes import Array, Float

FlownFlight = tuple[Flight, Found]


@dataclass(frozen=True, slots=True)
class Forecast:
    """One flight with what was forecast before it flew, by the model and by its rivals. [m]

    `draws` are the model's equally likely apogees and `p05` to `p95` its quantiles; `rivals` are the draws of those
    rivals that had something to go by, `stacked` the mixture with some of them. `earlier` counts the clean flights with
    an apogee that its rocket had flown. `corrected` is the 90 % interval after `corrected_by_earlier`, by a factor
    `stretch`; both None while too few forecasts came before.
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

    @property
    def interval(self) -> tuple[float, float, float]:
        """The model's quantiles at 5, 50 and 95 %. [m]"""
        return self.p05, self.p50, self.p95


def forward(
    flown: Sequence[FlownFlight],
    rocket: str | None = None,
    *,
    hyperprior: Hyperprior | None = None,
    on_progress: ReportProgress = no_op,
) -> list[Forecast]:
    """A forecast of every clean flight with an apogee, from the flights of all rockets before it in the order flown.

    With `rocket` only those of that rocket are forecast, still from the flights of all. What a rocket shows of the
    fleet is computed again when it has flown. `hyperprior` takes the place of the learned one.
    """
    known = hyperprior or learned()
    past: dict[str, list[FlownFlight]] = {}
    fits: dict[str, tuple[int, RocketFit]] = {}
    earlier: list[Simulated] = []
    rows: list[Forecast] = []
    for number, one in enumerate(simulate(flown)):
        own = past.setdefault(one.flight.rocket, [])
        if one.flight.clean and one.flight.apogee is not None:
            if rocket in (None, one.flight.rocket):
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
    """What the flights so far of all other rockets show; `fits` holds those of rockets that have not flown since."""
    found = []
    for name, flown in past.items():
        teaching = [(flight, motor) for flight, motor in flown if flight.clean and flight.readouts()]
        if name == rocket or not teaching:
            continue
        if name not in fits or fits[name][0] != len(teaching):
            fits[name] = len(teaching), rocket_fit(teaching, hyperprior)
        found.append(fits[name][1])
    return shared_prior(found)


def _forecast(
    past: Sequence[FlownFlight],
    plan: Simulated,
    earlier: Sequence[Simulated],
    shared: SharedPrior | None,
    hyperprior: Hyperprior | None,
) -> Forecast:
    """One flight with its forecasts."""
    (made,) = predict(past, [(unflown(plan.flight), plan.found)], shared=shared, hyperprior=hyperprior)
    p05, p50, p95 = made.apogee_quantiles().tolist()
    return beside_rivals(plan, made.apogee, (p05, p50, p95), earlier)


def unflown(flight: Flight) -> Flight:
    """A flight as it was planned: without its readouts."""
    return flight.with_changes(**dict.fromkeys(flight.readouts()))


def beside_rivals(
    plan: Simulated,
    draws: Float[Array, "draw"],
    interval: tuple[float, float, float],
    earlier: Sequence[Simulated],
) -> Forecast:
    """A flight, simulated as it was planned, with its forecast and what the rivals make of earlier flights."""
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
    """The forecasts, in the order flown, each with its mixture with rivals, weighted by those of earlier flights."""
    found: list[Forecast] = []
    scores: list[Float[Array, "way"]] = []
    for row in rows:
        mixture = mixed_in(row.draws, row.rivals, weights_after(scores))
        found.append(replace(row, rivals={**row.rivals, "stacked": mixture}))
        scores.append(log_scores(row.draws, row.rivals, row.flown))
    return found


def next_weights(rows: Sequence[Forecast]) -> dict[str, float]:
    """The weights that the flight after these would be stacked with, by way. [1]"""
    weights = weights_after([log_scores(row.draws, row.rivals, row.flown) for row in rows])
    return dict(zip(("fieldkit", *STACKED_RIVALS), weights.tolist(), strict=True))


def corrected_by_earlier(rows: Sequence[Forecast]) -> list[Forecast]:
    """The forecasts, in the order flown, each with its interval corrected by how those of earlier flights fared.

    The correction is by the forecasts of all rockets given, for one rocket rarely has enough.
    """
    found: list[Forecast] = []
    surprises: list[float] = []
    for row in rows:
        by = stretch(surprises)
        if by is not None:
            low, _, high = stretched(row.interval, by)
            row = replace(row, stretch=by, corrected=(low, high))
        found.append(row)
        surprises.append(surprise(row.flown, row.interval))
    return found


def corrected_coverage(rows: Sequence[Forecast]) -> dict[str, float | None] | None:
    """Coverage of the intervals that earlier flights corrected, and of the model's own for the same flights. [1]"""
    later = [(row, row.corrected) for row in rows if row.corrected]
    if not later:
        return None
    inside = [low <= row.flown <= high for row, (low, high) in later]
    own = [row.p05 <= row.flown <= row.p95 for row, _ in later]
    coverage = {"coverage90": sum(inside) / len(later), "own_coverage90": sum(own) / len(later)}
    return {"flights": len(later), **coverage, "last_stretch": later[-1][0].stretch}
