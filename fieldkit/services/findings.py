"""All that is reported of a closed loop, computed once: the terminal, the JSON and the page show the same figures."""

from collections.abc import Mapping
from dataclasses import dataclass

from fieldkit.analysis import Recorded
from fieldkit.progress import ReportProgress, no_op
from fieldkit.scoring.bootstrap import Interval, Judged, gain, judge
from fieldkit.selection.averaged import Ahead, ahead
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.fingerprint import FingerprintMark, marks
from fieldkit.selection.force.log_evidence import LogEvidence, compare_with_logs
from fieldkit.selection.next_experiment import Advice, Explanation, informative_readouts
from fieldkit.selection.residual import Pattern, ResidualDistribution, patterns, readout_patterns, spreads
from fieldkit.selection.trial import Trial
from fieldkit.selection.unexplained import Leftover, leftover
from fieldkit.selection.verdict import best_with

EVALUATION = (
    "leave-one-flight-out, effects weighed anew inside every fold "
    "(Pareto-smoothed importance sampling, fitted again without the flight where that is unsure; "
    "which effects are averaged over was found with all flights)"
)
FORWARD_METHOD = (
    "each flight forecast from the flights before it, effects weighed anew by those at every flight "
    "(readouts linear about the fits to all flights, which found the effects averaged over)"
)
MAX_SHOWN_EFFECTS = 3
"""Effects whose fingerprint is shown, and tests that are advised. [1]"""


@dataclass(frozen=True, slots=True)
class Compared:
    """Errors before and after, and by how much the mean absolute error fell. [m]"""

    before: Judged
    after: Judged
    gain: float
    gain_interval: Interval
    how: str


@dataclass(frozen=True, slots=True)
class Findings:
    """A diagnosis of a rocket with everything that is said of it.

    `left_out` are errors of flights left out, `forward` of flights forecast from earlier ones. `fingerprints` are
    those of the accepted effects, else of the likeliest. `tests` would tell the accepted effect from those that
    it cannot be told from. `unexplained` is there where the verdict is. `testimony` is what logs of the climb say,
    which had no part in the verdict.
    """

    rocket: str
    diagnosis: Diagnosis
    left_out: Compared
    forward: Compared
    ahead: Ahead
    patterns: tuple[Pattern, ...]
    readout_patterns: tuple[Pattern, ...]
    spreads: tuple[ResidualDistribution, ...]
    fingerprints: tuple[tuple[Trial, tuple[FingerprintMark, ...]], ...]
    tests: tuple[Advice, ...]
    unexplained: Leftover | None
    testimony: LogEvidence


def findings(
    rocket: str,
    diagnosis: Diagnosis,
    on_progress: ReportProgress = no_op,
    logs: Mapping[str, Recorded | str] | None = None,
) -> Findings:
    """Everything that is reported of a diagnosis; `logs` as `fieldkit.services.flight_logs.kept_logs` has them."""
    truth, seen = diagnosis.data.values[:, 0], diagnosis.data.seen[:, 0]
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
        testimony=compare_with_logs(diagnosis, logs or {}),
    )


def _shown(diagnosis: Diagnosis) -> list[Trial]:
    """The effects to show: the accepted ones first, then the likeliest."""
    named = [item.best for item in diagnosis.ranking if item.effect]
    first = [trial for trial in named if trial.candidate.effect in diagnosis.effect.split("+")]
    return [*first, *(trial for trial in named if trial not in first)][:MAX_SHOWN_EFFECTS]


def _tests(diagnosis: Diagnosis) -> tuple[Advice, ...]:
    """What would tell the accepted effect from the likeliest of those it cannot be told from."""
    if not diagnosis.accepted or not diagnosis.also:
        return ()
    accepted = best_with(diagnosis.posterior, diagnosis.effect.split("+"))
    rival = best_with(diagnosis.posterior, diagnosis.also[0].split("+"))
    sides = [Explanation(one.places, one.fit) for one in (accepted, rival)]
    return distinct(informative_readouts(diagnosis.model, *sides))


def distinct(tests: list[Advice]) -> tuple[Advice, ...]:
    """The most telling tests, one flight for each motor."""
    kept: dict[str, Advice] = {}
    for test in tests:
        kept.setdefault(test.subject, test)
    return tuple(kept.values())[:MAX_SHOWN_EFFECTS]
