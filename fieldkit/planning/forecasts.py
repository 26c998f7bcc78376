"""Forecasts of plans that a flyer chooses among, from what is known of a rocket."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fieldkit.flight import Flight
from fieldkit.flight.start import Start, design_cds
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.predict import FittedForecast, fly_ahead, learn
from fieldkit.forecast.prediction import Prediction
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found
from fieldkit.selection.candidates import Averaged
from fieldkit.shapes import Array, Float

Planned = Sequence[tuple[Flight, Found]]


@dataclass(frozen=True, slots=True)
class Rocket:
    """What is known of a rocket that forecasts rest on: its flights, the sets of effects in its model, by how much
    intervals are `stretched` for how `earlier` forecasts fared, the designs it starts from, and what the flyer's other
    rockets show."""

    history: tuple[tuple[Flight, Found], ...]
    averaged: Averaged
    stretched: float | None
    earlier: int
    starts: tuple[Start, ...] = ()
    shared: SharedPrior | None = None
    implausible: tuple[str, ...] = ()
    """A line for each flight that no rocket can have flown, and that no forecast rests on."""

    @property
    def flights(self) -> list[Flight]:
        """The flights that physics can follow, in order."""
        return [flight for flight, _ in self.history]

    @property
    def motors(self) -> list[Found]:
        """The motors of these flights."""
        return [found for _, found in self.history]


def forecasts(
    rocket: Rocket,
    planned: Planned,
    *,
    draws: int,
    paired: bool = True,
    delay_sd: Float[Array, "flight"] | None = None,
) -> list[Prediction]:
    """Forecasts of plans that a flyer chooses among, each as the next flight, as `predict` would make them, in the
    order given; nothing is kept.

    `paired` and `delay_sd` as in `fieldkit.forecast.predict.fly_ahead`. Raises ImpossibleFlight for a plan without a
    mass.
    """

    def said(rows: Sequence[int]) -> list[Prediction]:
        fitted = fitted_forecast(rocket, [planned[row] for row in rows], draws)
        return flown_ahead(rocket, fitted, paired, None if delay_sd is None else delay_sd[list(rows)])

    return by_kind(rocket.history, planned, said)


def fitted_forecast(rocket: Rocket, planned: Planned, draws: int) -> FittedForecast:
    """The forecast fitted to a rocket's flights for plans of one kind, each as the next flight."""
    cds = design_cds(rocket.starts, [flight for flight, _ in (*rocket.history, *planned)])
    return learn(rocket.history, planned, averaged=rocket.averaged, cds=cds, shared=rocket.shared, draws=draws)


def flown_ahead(
    rocket: Rocket,
    fitted: FittedForecast,
    paired: bool = True,
    delay_sd: Float[Array, "flight"] | None = None,
) -> list[Prediction]:
    """The fit, flown as in `fly_ahead`, with intervals as wide as this rocket's have to be."""
    made = fly_ahead(fitted, paired=paired, delay_sd=delay_sd)
    made = [one.corrected(rocket.stretched, rocket.earlier) for one in made]
    return [replace(one, left_out=(*rocket.implausible, *one.left_out)) for one in made]
