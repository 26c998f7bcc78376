"""Fit the hyperprior to the exports of several flyers, and cross-validate it by rocket."""

import hashlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any

from fieldkit import __version__
from fieldkit.errors import FieldkitError, NoFlights, UnknownMotor
from fieldkit.file_lock import changing
from fieldkit.files import read
from fieldkit.files import replace as replace_file
from fieldkit.flight import Flight
from fieldkit.flight.plausibility import implausible
from fieldkit.forecast.evaluation.comparison import OWN_FORECAST, scores_of_flights, tally
from fieldkit.forecast.evaluation.forward_in_time import Forecast, forward, with_stacked
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.inference.laplace.learning import evidence, learn_hyperprior
from fieldkit.model.hyperprior import START, Hyperprior, learned
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.motors import Catalogue
from fieldkit.paths import hyperprior_file
from fieldkit.progress import ReportProgress, no_op
from fieldkit.scoring.bootstrap import paired
from fieldkit.services.imports import gather
from fieldkit.services.plausible_flights import implausible_flights

FULL_ROUNDS, FULL_STEPS = 4, 25
"""Number of linearizations, and steps for each, in the fit to all flights. [1]"""
LEFT_OUT_ROUNDS, LEFT_OUT_STEPS = 1, 12
"""The same for a fit without one rocket, which starts from the fit to all, because one rocket changes little."""
ALL_READOUTS = "all readouts"
READOUT_STEPS: Mapping[str, Collection[str]] = {
    "apogee alone": ("apogee",),
    "and top speed": ("apogee", "top_speed"),
    "and coast, ejection": ("apogee", "top_speed", "coast_to_apogee", "apogee_to_eject"),
    ALL_READOUTS: OBSERVED_READOUTS,
}
"""Readouts from which flights are forecast, each step with more than the one before."""
StepForecasts = dict[str, list[Forecast]]
"""Forecasts of flights by the names of `READOUT_STEPS`."""


@dataclass(frozen=True, slots=True)
class Flyer:
    """The flights of one flyer, in the order flown, and the digests of their files; `left_out` has a line for each
    clean flight that is implausible."""

    name: str
    flown: list[FlownFlight]
    digests: Mapping[str, str]
    left_out: tuple[str, ...] = ()

    @property
    def rockets(self) -> dict[str, list[FlownFlight]]:
        """The clean flights, rocket by rocket."""
        found: dict[str, list[FlownFlight]] = {}
        for flight, motor in self.flown:
            if flight.clean and flight.readouts():
                found.setdefault(flight.rocket, []).append((flight, motor))
        return found


def read_flyer(path: Path, motors: Catalogue, since: date | None = None) -> Flyer:
    """The flights of one flyer: of a flight table, or of a folder of files; only those since a day, or without a date.

    Raises FieldkitError, NoFlights.
    """
    paths = sorted(file for file in path.iterdir() if file.is_file()) if path.is_dir() else [path]
    gathered = gather(paths, motors.complaint)
    known: list[FlownFlight] = []
    for incoming in gathered.incoming_flights:
        if incoming.flight.dry_mass is None:
            continue
        try:
            known.append((incoming.flight, motors.resolve(incoming.flight.motor)))
        except UnknownMotor:
            continue
    usable = [
        (flight, motor)
        for flight, motor in known
        if not implausible(flight, motor.motor)
        and (since is None or flight.date_time is None or flight.date_time.date() >= since)
    ]
    if not usable:
        raise NoFlights(f"{path}: found no flight with a dry mass and a known motor, expected at least one")
    dated = sorted(usable, key=lambda one: (one[0].date_time is not None, str(one[0].date_time or "")))
    digests = {file.name: hashlib.sha256(read(file)).hexdigest() for file in paths}
    excluded = implausible_flights([incoming.flight for incoming in gathered.incoming_flights], motors)
    return Flyer(path.stem, dated, digests, tuple(f"{path.name}: {line}" for line in excluded))


def learn(
    flyers: Sequence[Flyer], *, from_start: bool = False, since: date | None = None, on_progress: ReportProgress = no_op
) -> Hyperprior:
    """The hyperprior fitted to the flights of some flyers, starting from the one in use, or from `START` if
    `from_start`. Raises DamagedModel if the one in use cannot be read."""

    start = START if from_start else learned()
    fleets = [list(flyer.rockets.values()) for flyer in flyers]
    found = learn_hyperprior(fleets, start, FULL_ROUNDS, FULL_STEPS, on_progress=on_progress)
    options = ["--from-scratch"] * from_start + [f"--since {since}"] * (since is not None)
    about = {
        "name": "hyperprior",
        "command": " ".join(["fieldkit learn", *options, *(flyer.name for flyer in flyers)]),
        "made_with": {"fieldkit": __version__},
        "data": [
            {
                "flyer": flyer.name,
                "flights": sum(len(own) for own in flyer.rockets.values()),
                "rockets": len(flyer.rockets),
                "sha256": flyer.digests,
            }
            for flyer in flyers
        ],
        "log_evidence": {"before": evidence(fleets, start), "after": evidence(fleets, found)},
    }
    return replace(found, about=about)


@dataclass(frozen=True, slots=True)
class HeldOutRocket:
    """A rocket whose flights are forecast with a hyperprior fitted without them."""

    flyers: tuple[Flyer, ...]
    flyer: int
    rocket: str
    hyperprior: Hyperprior
    from_start: bool


def left_out(flyers: Sequence[Flyer], hyperprior: Hyperprior, *, from_start: bool = False) -> Iterator[HeldOutRocket]:
    """Every rocket of every flyer, each left out in turn."""
    for number, flyer in enumerate(flyers):
        for rocket in flyer.rockets:
            yield HeldOutRocket(tuple(flyers), number, rocket, hyperprior, from_start)


def forecasts_of(work: HeldOutRocket) -> StepForecasts:
    """Forecasts, forward in time, of a rocket's flights by a hyperprior fitted without them, from some readouts of the
    earlier flights and from all. Raises DamagedModel."""
    fleets = [
        [own for rocket, own in flyer.rockets.items() if (number, rocket) != (work.flyer, work.rocket)]
        for number, flyer in enumerate(work.flyers)
    ]
    without = learn_hyperprior(
        [fleet for fleet in fleets if fleet],
        START if work.from_start else learned(),
        LEFT_OUT_ROUNDS,
        LEFT_OUT_STEPS,
        begin=work.hyperprior,
    )
    flown = work.flyers[work.flyer].flown
    found: StepForecasts = {}
    for step, readouts in READOUT_STEPS.items():
        known = [(_restricted(flight, readouts), motor) for flight, motor in flown]
        if step == ALL_READOUTS or known != flown:
            found[step] = forward(known, work.rocket, hyperprior=without)
    return found


def _restricted(flight: Flight, readouts: Collection[str]) -> Flight:
    """A flight without the readouts that are compared with the model, except some."""
    left_out = [name for name in OBSERVED_READOUTS if name not in readouts and flight.number(name) is not None]
    return flight.with_changes(**dict.fromkeys(left_out)) if left_out else flight


def check(
    flyers: Sequence[Flyer],
    hyperprior: Hyperprior,
    *,
    from_start: bool = False,
    pool: Executor | None = None,
    on_progress: ReportProgress = no_op,
) -> dict[str, StepForecasts]:
    """Cross-validated forecasts of all flights, the hyperprior fitted without the rocket of each, by flyer and by the
    readouts of earlier flights, in the order flown."""
    works = list(left_out(flyers, hyperprior, from_start=from_start))
    apply: Callable[..., Iterator[StepForecasts]] = pool.map if pool else map
    found: dict[str, StepForecasts] = {flyer.name: {} for flyer in flyers}
    for number, (work, steps) in enumerate(zip(works, apply(forecasts_of, works), strict=True)):
        on_progress(f"without {work.rocket}", (number + 1) / len(works))
        for step, rows in steps.items():
            found[flyers[work.flyer].name].setdefault(step, []).extend(rows)
    for flyer in flyers:
        order = {(one.rocket, one.flight_id): place for place, (one, _) in enumerate(flyer.flown)}
        for step, rows in found[flyer.name].items():
            rows.sort(key=lambda row: order[row.rocket, row.flight_id])
            found[flyer.name][step] = with_stacked(rows)
    return found


def scores(checked: Mapping[str, StepForecasts]) -> dict[str, Any]:
    """Scores of cross-validated forecasts and of their rivals, by flyer, for the card: of flights whose rocket had
    flown before, and of all flights, first flights included."""

    def ways(rows: Sequence[Forecast]) -> list[dict[str, Any]]:
        return [asdict(one) for name in (OWN_FORECAST, *LABELS) if (one := tally(rows, name)).flights]

    found = {name: steps[ALL_READOUTS] for name, steps in checked.items()}
    return {
        name: {"after earlier flights of the rocket": ways([row for row in rows if row.earlier]), "all": ways(rows)}
        for name, rows in found.items()
    }


def scores_by_readouts(checked: Mapping[str, StepForecasts]) -> dict[str, Any]:
    """Scores of cross-validated forecasts from more and more readouts, by flyer, for the card; without flyers whose
    flights have no other readout than the apogee. Each step has its mean log score [nat] and, with its 90% bootstrap
    interval, how much smaller its CRPS is than that of the step before."""
    return {
        name: {
            "after earlier flights of the rocket": _steps(steps, later=True),
            "first flights": _steps(steps, later=False),
        }
        for name, steps in checked.items()
        if len(steps) > 1
    }


def _steps(steps: StepForecasts, *, later: bool) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    before: Any = None
    for step in (name for name in READOUT_STEPS if name in steps):
        rows = [row for row in steps[step] if bool(row.earlier) is later]
        if not rows:
            continue
        crps = scores_of_flights(rows, OWN_FORECAST).crps
        less = paired(crps, before) if before is not None else None
        log_score = sum(row.log_scores[0] for row in rows) / len(rows)
        found.append(
            asdict(tally(rows, OWN_FORECAST))
            | {"name": step, "log_score": log_score}
            | ({"crps_less": less.less, "crps_less90": list(less.interval)} if less else {})
        )
        before = crps
    return found


def own_card() -> bytes:
    """The flyer's card as it is on the disk, empty if there is none or if it cannot be read."""
    try:
        return read(hyperprior_file(), plain=True)
    except OSError:
        return b""


def keep_card(text: str, before: bytes) -> Path:
    """Save a card that was learned from the one that was there `before`; returns its file.

    Raises FieldkitError if another program has saved one in the meantime, or if it cannot be written.
    """
    own = hyperprior_file()
    with changing(own):
        if own_card() != before:
            raise FieldkitError(f"{own}: another program has saved a card in the meantime; learn again")
        replace_file(own, text.encode())
    return own
