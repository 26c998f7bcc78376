"""The findings of a closed loop, computed once, so that terminal, JSON and page show the same figures."""

from dataclasses import dataclass, replace
from math import log

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.evaluation.rivals import RivalScore
from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.forecast.predict import Fits, predict
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.progress import ReportProgress, no_op
from fieldkit.scoring.bootstrap import Interval, Judged, gain, judge
from fieldkit.selection.averaged import Ahead, ahead
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.fingerprint import FingerprintMark, marks
from fieldkit.selection.next_experiment import Advice, Explanation, informative_readouts
from fieldkit.selection.prior import UNEXPLAINED
from fieldkit.selection.residual import ColumnPattern, ResidualDistribution, patterns, readout_patterns, spreads
from fieldkit.selection.trial import Trial
from fieldkit.selection.unexplained import Leftover, leftover
from fieldkit.selection.verdict import NAMING_PROBABILITY

EVALUATION = (
    "leave-one-flight-out, effects reweighted within every fold "
    "(Pareto-smoothed importance sampling, refitted without the flight if that is unreliable; "
    "the set of effects averaged over, and whether to average, was chosen with all flights)"
)
CANDIDATE_EVALUATION = (
    "leave-one-flight-out, each effect alone in the place that all flights chose, "
    "readouts linearized about its fit to all flights"
)
FORWARD_METHOD = (
    "each flight forecast from the flights before it, effects reweighted by those at every flight "
    "(readouts linearized about the fits to all flights, which chose the effects averaged over)"
)
NEXT_FLIGHT_DRAWS = 400
"""Number of draws of the next flight's forecast. [1]"""
WORTH_A_TEST = 0.02
"""Minimum probability of an alternative explanation for suggesting a test against it. [1]"""
DECISIVE_EVIDENCE = log(NAMING_PROBABILITY / (1 - NAMING_PROBABILITY))
"""Expected log Bayes factor from which a test may decide: it brings one of two equally probable explanations to the
probability of a name. [nat]"""
MAX_SHOWN_EFFECTS = 3
"""Number of effects with fingerprints, and of suggested tests. [1]"""


@dataclass(frozen=True, slots=True)
class Compared:
    """Errors before and after, and by how much the model average reduces the mean absolute error. [m]"""

    before: Judged
    after: Judged
    gain: float
    gain_interval: Interval
    how: str


@dataclass(frozen=True, slots=True)
class RepeatedFlight:
    """Forecasts of repeating the last flight: the apogee by the plain model and by the model average, with the latter's
    90% interval. [m]"""

    flight: Flight
    before: float
    after: float
    interval: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Findings:
    """A diagnosis of a rocket with all figures for a report.

    `left_out` are leave-one-out errors, `forward` are errors of forecasts from earlier flights. `fingerprints` are
    those of the accepted effects, or else of the most likely. `tests` would distinguish the most probable explanation
    from the next. `next_flight` has the forecasts of the flight after the last. `unexplained` is set if the verdict is
    "unexplained".
    """

    rocket: str
    diagnosis: Diagnosis
    left_out: Compared
    forward: Compared
    ahead: Ahead
    patterns: tuple[ColumnPattern, ...]
    readout_patterns: tuple[ColumnPattern, ...]
    spreads: tuple[ResidualDistribution, ...]
    fingerprints: tuple[tuple[Trial, tuple[FingerprintMark, ...]], ...]
    tests: tuple[Advice, ...]
    unexplained: Leftover | None
    next_flight: RepeatedFlight
    excluded: tuple[str, ...] = ()
    """Notes on the clean flights that the fit did not use."""
    flights: tuple[FlightBesideOthers, ...] = ()
    """Every flight beside its forecast from the others, and what went wrong on it."""
    rivals: tuple[RivalScore, ...] = ()
    """Simple forecasts of each flight from the earlier ones."""


def findings(
    rocket: str,
    diagnosis: Diagnosis,
    on_progress: ReportProgress = no_op,
    upcoming: RepeatedFlight | None = None,
) -> Findings:
    """The findings for a diagnosis. `upcoming` is by default forecast from the diagnosed flights alone."""
    model, truth, seen = diagnosis.model, diagnosis.data.values[:, 0], diagnosis.data.seen[:, 0]
    flown = tuple(zip(model.flights, model.found, strict=True))
    forward = ahead(diagnosis.posterior, on_progress)
    before, after = diagnosis.forecasts_before, diagnosis.forecasts_after
    return Findings(
        rocket=rocket,
        diagnosis=diagnosis,
        left_out=Compared(
            judge(before, truth, seen), judge(after, truth, seen), *gain(before, after, truth, seen), EVALUATION
        ),
        forward=Compared(
            judge(forward.before, truth, forward.seen),
            judge(forward.after, truth, forward.seen),
            *gain(forward.before, forward.after, truth, forward.seen),
            FORWARD_METHOD,
        ),
        ahead=forward,
        patterns=tuple(patterns(diagnosis)),
        readout_patterns=tuple(readout_patterns(diagnosis)),
        spreads=tuple(spreads(diagnosis)),
        fingerprints=tuple((trial, tuple(marks(diagnosis, trial))) for trial in _shown(diagnosis)),
        tests=_tests(diagnosis),
        unexplained=leftover(diagnosis) if diagnosis.effect == "unexplained" else None,
        next_flight=upcoming or next_flight(flown, Assumed(diagnosis.averaged)),
    )


def _shown(diagnosis: Diagnosis) -> list[Trial]:
    """The effects to show: first the accepted ones, then the most likely."""
    named = [item.best for item in diagnosis.ranking if item.effect]
    first = [trial for trial in named if trial.candidate.effect in diagnosis.effect.split("+")]
    return [*first, *(trial for trial in named if trial not in first)][:MAX_SHOWN_EFFECTS]


def next_flight(history: FlownFlights, assumed: Assumed, *, fits: Fits | None = None) -> RepeatedFlight:
    """The forecasts of repeating the last flight, without any effect and as assumed; arguments as in `predict`."""
    last, motor = history[-1]
    plan = [(last.unflown(tags=()), motor)]
    none = replace(assumed, sets=(), declared=False)
    (before,), (after,) = (predict(history, plan, one, draws=NEXT_FLIGHT_DRAWS, fits=fits) for one in (none, assumed))
    low, middle, high = after.apogee_quantiles()
    return RepeatedFlight(last, before.apogee_quantiles()[1], middle, (low, high))


def _tests(diagnosis: Diagnosis) -> tuple[Advice, ...]:
    """The tests that would distinguish the most probable explanation from the second most probable."""
    posterior, names = diagnosis.posterior, frozenset(diagnosis.effect.split("+"))
    known = {members: chance for members, chance in posterior.sets.items() if UNEXPLAINED not in members}
    named = [members for members in known if diagnosis.accepted and names <= members]
    others = [members for members in known if members not in named]
    if not named:
        named, others = others[:1], others[1:]
    if not named or not others or known[others[0]] < WORTH_A_TEST:
        return ()
    sides = [Explanation(one.places, one.fit) for one in (posterior.best(named[0]), posterior.best(others[0]))]
    return distinct(informative_readouts(diagnosis.model, *sides))


def distinct(tests: list[Advice]) -> tuple[Advice, ...]:
    """The most informative tests that may decide, one flight for each motor."""
    kept: dict[str, Advice] = {}
    for test in tests:
        if test.expected < DECISIVE_EVIDENCE:
            continue
        kept.setdefault(test.subject, test)
    return tuple(kept.values())[:MAX_SHOWN_EFFECTS]
