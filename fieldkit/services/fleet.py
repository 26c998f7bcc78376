"""What the other rockets of a ledger show of what they share with one: the fleet's level, and motor types.

Each rocket's message is kept in the ledger, with a digest of what it was computed from, and computed again when its
flights, its motors or the hyperprior change.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.motors import Catalogue, Found
from fieldkit.progress import ReportProgress, no_op
from fieldkit.services.plausible_flights import followed
from fieldkit.services.provenance import flight_digest, motor_digest

if TYPE_CHECKING:
    from fieldkit.inference.laplace.fleet import RocketFit
    from fieldkit.model.shared_prior import SharedPrior

MESSAGE_PREFIX = "fleet: "
"""Prefix of the name under which the ledger stores a rocket's message."""
DIGITS = 7
"""Significant digits of a saved figure: far more than a forecast shows. [1]"""

FlownFlights = Sequence[tuple[Flight, Found]]


def fleet_prior(
    ledger: Ledger, motors: Catalogue, rocket: str, on_progress: ReportProgress = no_op
) -> "SharedPrior | None":
    """What the clean flights of all other rockets of a ledger show of the terms shared with one; None without any.

    `on_progress` hears of each rocket that is fitted again.
    """
    from fieldkit.inference.laplace.fleet import shared_prior

    own = learned()
    others = _by_rocket(ledger, motors, rocket)
    fits = []
    for number, (name, flown) in enumerate(others.items()):
        on_progress(name, number / len(others))
        fits.append(_rocket_fit(ledger, name, flown, own))
    return shared_prior(fits)


def _by_rocket(ledger: Ledger, motors: Catalogue, rocket: str) -> dict[str, list[tuple[Flight, Found]]]:
    """The flights of all other rockets that show something, rocket by rocket."""
    found: dict[str, list[tuple[Flight, Found]]] = {}
    for flight, motor in followed(ledger.flights(), motors):
        if flight.rocket != rocket and flight.clean and flight.readouts():
            found.setdefault(flight.rocket, []).append((flight, motor))
    return found


def _rocket_fit(ledger: Ledger, rocket: str, flown: FlownFlights, hyperprior: Hyperprior) -> "RocketFit":
    """A rocket's fit by itself, from the ledger where that is up to date."""
    from fieldkit.inference.laplace.fleet import rocket_fit

    digest = _digest(flown, hyperprior)
    kept = ledger.draft(MESSAGE_PREFIX + rocket)
    if kept is not None and kept.get("digest") == digest:
        return _read(kept)
    made = rocket_fit(flown, hyperprior)
    try:
        ledger.keep_draft(MESSAGE_PREFIX + rocket, {"digest": digest, **_written(made)})
    except LedgerError:  # one that cannot be written to is slower and no less right
        return made
    return made


def _digest(flown: FlownFlights, hyperprior: Hyperprior) -> str:
    motors = {id(found.motor): motor_digest(found.motor) for _, found in flown}
    parts = [hyperprior.json(), [(flight_digest(flight), motors[id(found.motor)]) for flight, found in flown]]
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:24]


def _written(made: "RocketFit") -> dict[str, Any]:
    def rounded(values: Any) -> list[float]:
        return [float(f"{value:.{DIGITS}g}") for value in values]

    message, prior = made.message, made.prior
    return {
        "log_evidence": made.log_evidence,
        "names": list(message.names),
        "precision": [rounded(row) for row in message.precision],
        "shift": rounded(message.shift),
        "prior_mean": rounded(prior.mean),
        "prior_variance": rounded(prior.covariance.diagonal()),
    }


def _read(kept: Mapping[str, Any]) -> "RocketFit":
    import numpy as np

    from fieldkit.inference.laplace.fleet import RocketFit
    from fieldkit.model.shared_prior import Message, SharedPrior

    names = tuple(kept["names"])
    message = Message(names, np.array(kept["precision"]), np.array(kept["shift"]))
    prior = SharedPrior(names, np.array(kept["prior_mean"]), np.diag(kept["prior_variance"]))
    return RocketFit(kept["log_evidence"], message, prior)
