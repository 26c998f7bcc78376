"""Plans for a rocket of a ledger, asked for by name: what the ledger says of it, and forecasts of plans."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fieldkit.flight import Flight
from fieldkit.forecast.conformal import kept_surprises, stretch
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.predict import Learnt, fly_ahead, learn
from fieldkit.forecast.prediction import Prediction
from fieldkit.ledger import Ledger, Start
from fieldkit.ledger.sites import site_of
from fieldkit.motors import Catalogue, Found
from fieldkit.selection.candidates import Place
from fieldkit.services.forecasts import accepted_places, accepted_widening, completed, design_cds, flown, start_of
from fieldkit.settings import Settings
from fieldkit.shapes import Array, Float

Planned = Sequence[tuple[Flight, Found]]


@dataclass(frozen=True, slots=True)
class Rocket:
    """What a ledger holds of a rocket that forecasts rest on: its flights, the effects in its model, by how much
    intervals are widened, for what the model leaves unexplained and for how `earlier` forecasts fared, and the
    designs it starts from."""

    history: tuple[tuple[Flight, Found], ...]
    places: tuple[Place, ...]
    widened: float
    stretched: float | None
    earlier: int
    starts: tuple[Start, ...] = ()

    @property
    def flights(self) -> list[Flight]:
        """The flights that physics can follow, in order."""
        return [flight for flight, _ in self.history]

    @property
    def motors(self) -> list[Found]:
        """The motors of these flights."""
        return [found for _, found in self.history]


def rocket_of(ledger: Ledger, motors: Catalogue, name: str) -> Rocket:
    """What a ledger holds of a rocket, read once."""
    surprises = kept_surprises([kept.payload for kept in ledger.predictions()])
    return Rocket(
        history=tuple(flown(ledger, motors, name)),
        places=accepted_places(ledger, name),
        widened=accepted_widening(ledger, name),
        stretched=stretch(surprises),
        earlier=len(surprises),
        starts=tuple(ledger.starts(name)),
    )


def begun(ledger: Ledger, plan: Flight, settings: Settings) -> Flight:
    """A plan with all that it leaves open and that is known: mass, diameter and rail as the rocket last flew, mass and
    diameter else of its design, the rail else the flyer's usual one; the site as last, and its elevation. Weather is
    the day's, and nothing is made up for it."""
    alike = [flight for flight in ledger.flights(plan.rocket) if flight.dry_mass is not None]
    plan = completed(plan, alike, start_of(ledger, plan))
    last = ledger.latest()
    if not plan.site and plan.site_elevation is None and last is not None:
        plan = plan.with_changes(site=last.site)
    known: dict[str, Any] = {"rail_length": settings.rail_length, "rail_angle": settings.rail_angle}
    known["site_elevation"] = site_of(ledger, plan.site).elevation
    return plan.with_changes(**{name: value for name, value in known.items() if plan.number(name) is None})


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
        learnt = learnt_of(rocket, [planned[row] for row in rows], draws)
        return flown_ahead(rocket, learnt, paired, None if delay_sd is None else delay_sd[list(rows)])

    return by_kind(rocket.history, planned, said)


def learnt_of(rocket: Rocket, planned: Planned, draws: int) -> Learnt:
    """What a rocket's flights taught of plans of a kind, each as the next flight, from the Cd of its design."""
    cds = design_cds(rocket.starts, [flight for flight, _ in (*rocket.history, *planned)])
    return learn(rocket.history, planned, rocket.places, cds=cds, draws=draws)


def flown_ahead(
    rocket: Rocket,
    learnt: Learnt,
    paired: bool = True,
    delay_sd: Float[Array, "flight"] | None = None,
    lean: Float[Array, "flight"] | None = None,
) -> list[Prediction]:
    """What was learnt, flown as in `fly_ahead`, with intervals as wide as this rocket's have to be."""
    made = fly_ahead(learnt, paired=paired, delay_sd=delay_sd, lean=lean)
    return [one.widened(rocket.widened).corrected(rocket.stretched, rocket.earlier) for one in made]
