"""Information from a ledger's other rockets about the terms they share with a rocket: fleet means and motor types.

Each rocket's message is saved in the ledger with a digest of its inputs. It is recomputed when its flights, its motors,
the hyperprior or the version of fieldkit change.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from fieldkit import __version__
from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.inference.laplace.fleet import RocketFit, rocket_fit, shared_prior
from fieldkit.ledger import Ledger
from fieldkit.model.fleet_drift import Period, period_of
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.model.shared_prior import Message, SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.motors import Catalogue, Found
from fieldkit.progress import ReportProgress, no_op
from fieldkit.quantities import counted
from fieldkit.services.plausible_flights import followed
from fieldkit.services.provenance import flight_digest, motor_digest

MESSAGE_PREFIX = "fleet: "
"""Prefix of the name under which the ledger stores a rocket's message."""
MAX_ROCKETS = 40
"""Number of rockets whose flights inform forecasts of the others, those flown latest: the mean of a fleet is then known
to a sixth of the differences between its rockets, and the prior of another one is at most 1.2% wider than with any
number of them, because the variance of what it shares with n others is that of one rocket times 1 + 1/n. With fewer,
less would be known of motors, too. Each takes a fit, once. [1]"""
DIGITS = 7
"""Significant digits of a saved figure. [1]"""


@dataclass(frozen=True, slots=True)
class _Fleet:
    """The flights used in the fit by rocket, and the fits so far, of one state of a ledger; `made_with` is as in
    `_rocket_fit`, `period` that of all flights."""

    changes: int
    motors: Catalogue
    made_with: str
    flown: Mapping[str, FlownFlights]
    period: Period | None
    fits: dict[str, RocketFit] = field(default_factory=dict)


_LATEST_FLEETS: WeakKeyDictionary[Ledger, _Fleet] = WeakKeyDictionary()
"""The latest fleet of each open ledger: to read 5,000 flights and digest them takes 0.4 s, and the app asks for each
forecast."""


def fleet_prior(
    ledger: Ledger, motors: Catalogue, rocket: str, on_progress: ReportProgress = no_op
) -> "SharedPrior | None":
    """The message of the clean flights of all other rockets of a ledger about the shared terms; None without any.

    `on_progress` is called for each rocket that is fitted again. Raises DamagedModel for an unreadable hyperprior.
    """
    return fleet_priors(ledger, motors, [rocket], on_progress)[rocket]


def fleet_priors(
    ledger: Ledger, motors: Catalogue, rockets: Sequence[str], on_progress: ReportProgress = no_op
) -> "dict[str, SharedPrior | None]":
    """`fleet_prior` of several rockets, each fitted at most once. Raises DamagedModel for an unreadable hyperprior."""

    own = learned()
    made_with = json.dumps(
        [__version__, TermName._fields, [one.name for one in fields(RocketFit)], own.json()], sort_keys=True
    )
    fleet = _fleet(ledger, motors, made_with)
    flown = {name: one for name, one in fleet.flown.items() if [name] != list(rockets)}
    period = fleet.period
    for number, (name, one) in enumerate(flown.items()):
        on_progress(name, number / len(flown))
        if name not in fleet.fits:
            fleet.fits[name] = _rocket_fit(ledger, name, one, own, made_with, period)
    return {rocket: shared_prior([fleet.fits[name] for name in flown if name != rocket], period) for rocket in rockets}


def _fleet(ledger: Ledger, motors: Catalogue, made_with: str) -> _Fleet:
    """The fleet of a ledger, read again only if the ledger, the motors, the hyperprior or fieldkit has changed."""
    changes, known = ledger.length(), _LATEST_FLEETS.get(ledger)
    if known is None or (known.changes, known.made_with) != (changes, made_with) or known.motors is not motors:
        flown = _by_rocket(ledger, motors)
        known = _LATEST_FLEETS[ledger] = _Fleet(changes, motors, made_with, flown, _period(ledger, flown))
    return known


def _period(ledger: Ledger, flown: Mapping[str, FlownFlights]) -> Period | None:
    """The period of a fleet. It begins with the first flight in the ledger, used or not: every fit depends on its
    beginning, and which flights are used changes with each new one."""
    known, first = period_of(flight for one in flown.values() for flight, _ in one), ledger.first_day()
    return (first or known[0], known[1]) if known else None


def _by_rocket(ledger: Ledger, motors: Catalogue) -> dict[str, list[tuple[Flight, Found]]]:
    """The flights used in the fit, by rocket: at most `MAX_ROCKETS`, those flown latest, which a remark says."""
    every, found = ledger.rockets_flown(), dict[str, list[tuple[Flight, Found]]]()
    if len(every) <= MAX_ROCKETS:
        for flight, motor in _used(ledger.flights(), motors):
            found.setdefault(flight.rocket, []).append((flight, motor))
        return found
    for rocket in every:
        if used := _used(ledger.flights(rocket), motors):
            found[rocket] = used
        if len(found) == MAX_ROCKETS:
            break
    ledger.remark(f"of {counted(len(every), 'rocket')} the {len(found)} flown latest inform forecasts of the others")
    return found


def _used(flights: Sequence[Flight], motors: Catalogue) -> list[tuple[Flight, Found]]:
    return [one for one in followed(flights, motors) if one[0].clean and one[0].readouts()]


def _rocket_fit(
    ledger: Ledger, rocket: str, flown: FlownFlights, hyperprior: Hyperprior, made_with: str, period: Period | None
) -> RocketFit:
    """A rocket's separate fit, from the ledger if it is up to date; `made_with` is the version of fieldkit and the
    hyperprior as text. Only the start of the `period` acts on flights that were flown."""
    digest = _digest(flown, f"{made_with} {period and period[0]}")
    kept = ledger.draft(MESSAGE_PREFIX + rocket)
    if kept is not None and kept.get("digest") == digest:
        return _read(kept)
    made = rocket_fit(flown, hyperprior, period)
    try:
        ledger.keep_draft(MESSAGE_PREFIX + rocket, {"digest": digest, **_written(made)})
    except LedgerError:  # a read-only ledger is slower, but the result is the same
        return made
    return made


def _digest(flown: FlownFlights, made_with: str) -> str:
    motors = {found.motor for _, found in flown}
    thrust = {motor: motor_digest(motor) for motor in motors}
    read = [(flight_digest(one), sorted(one.source.items()), thrust[found.motor]) for one, found in flown]
    return hashlib.sha256((made_with + json.dumps(read, sort_keys=True, default=str)).encode()).hexdigest()[:24]


def _written(made: RocketFit) -> dict[str, Any]:
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
        "scatter": rounded(made.scatter),
    }


def _read(kept: Mapping[str, Any]) -> RocketFit:

    names = tuple(TermName(*name) for name in kept["names"])
    message = Message(names, np.array(kept["precision"]), np.array(kept["shift"]))
    prior = SharedPrior(names, np.array(kept["prior_mean"]), np.diag(kept["prior_variance"]))
    return RocketFit(kept["log_evidence"], message, prior, tuple(kept["scatter"]))
