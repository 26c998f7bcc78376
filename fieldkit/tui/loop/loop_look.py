"""The requests of the Loop page: the models of a rocket, and the search for missing effects."""

from dataclasses import dataclass

from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.ledger import Version
from fieldkit.physics.effect import Effect, effects
from fieldkit.progress import ReportProgress
from fieldkit.services import close_loop
from fieldkit.services.findings import Findings
from fieldkit.services.forecasts import which_rocket
from fieldkit.services.plausible_flights import motor_type
from fieldkit.tui.resources import Resources

PANELS = ("Verdict", "Flights", "Versions", "Evidence", "Residuals", "Fingerprint", "Ranking")
"""The panels of the page, the last four a level down, shown one at a time or all of a level at once."""
FRONT = PANELS[:3]
"""The panels of the first level."""
PLAIN_MODEL = 0
"""The number of the model without any effect added."""


@dataclass(frozen=True, slots=True)
class Standing:
    """A rocket's models and flights, and the names of all rockets."""

    rocket: str
    rockets: tuple[str, ...]
    versions: tuple[Version, ...]
    flights: tuple[Flight, ...]
    tried: tuple[Effect, ...] = ()
    """The effects that a search tries."""
    motors: tuple[str, ...] = ()
    """The types of motors flown, each once."""

    @property
    def plain(self) -> bool:
        """Whether the rocket is predicted with the plain model."""
        return self.used == PLAIN_MODEL

    @property
    def used(self) -> int:
        """The number of the model in use."""
        return next((version.number for version in self.versions if version.active), PLAIN_MODEL)


def standing_of(resources: Resources, rocket: str | None) -> Standing | None:
    """The state of a rocket, or of the one flown last if none is given or it no longer exists; None if nothing has
    flown."""
    ledger = resources.ledger
    rockets = tuple(ledger.names("rocket"))
    if not rockets:
        return None
    name = which_rocket(ledger, rocket if rocket in rockets else None)
    tried = tuple(effect for effect in effects().values() if not effect.form_of)
    flights = ledger.flights(name)
    types = dict.fromkeys(motor_type(flight.motor, resources.motors) for flight in flights if flight.motor)
    return Standing(name, rockets, tuple(ledger.versions(name)), tuple(flights), tried, tuple(types))


def look(resources: Resources, rocket: str, on_progress: ReportProgress) -> Findings:
    """Search for effects that a rocket's model lacks, with its flights and their logs; nothing changes.

    Raises NoFlights if there are too few flights.
    """
    fits = resources.comparisons.fits(resources.ledger, rocket)
    return close_loop.look(resources.ledger, resources.motors, rocket, on_progress, fits=fits)


def beside_the_others(resources: Resources, rocket: str) -> tuple[FlightBesideOthers, ...]:
    """The flights of a rocket, each beside the others. Raises FieldkitError if they cannot be compared."""
    return resources.comparisons.of(resources.ledger, resources.motors, rocket)
