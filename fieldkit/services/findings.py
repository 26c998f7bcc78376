"""All that is reported of a closed loop, computed once: the terminal, the JSON and the page show the same figures."""

from collections.abc import Mapping
from dataclasses import dataclass

from fieldkit.analysis import Recorded
from fieldkit.forecast.widen import widened_leftover
from fieldkit.progress import ReportProgress, no_op
from fieldkit.scoring.bootstrap import Interval, Judged, gain, judge
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.fingerprint import FingerprintMark, marks
from fieldkit.selection.force.log_evidence import LogEvidence, compare_with_logs
from fieldkit.selection.forward_choice import Ahead, ahead
from fieldkit.selection.next_experiment import Advice, Explanation, informative_readouts
from fieldkit.selection.residual import Pattern, ResidualDistribution, patterns, readout_patterns, spreads
from fieldkit.selection.trial import Trial
from fieldkit.selection.unexplained import Leftover

EVALUATION = "leave-one-flight-out, effect chosen anew inside every fold"
FORWARD_METHOD = (
    "each flight forecast from the flights before it, effect chosen anew from those at every flight "
    "(readouts linear about the fit to all flights)"
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
    implausible: tuple[str, ...] = ()
    """A line for each flight that no rocket can have flown, and that had no part in any of this."""


def findings(
    rocket: str,
    diagnosis: Diagnosis,
    on_progress: ReportProgress = no_op,
    logs: Mapping[str, Recorded | str] | None = None,
) -> Findings:
    """Everything that is reported of a diagnosis; `logs` as `fieldkit.services.flight_logs.kept_logs` has them."""
    truth, seen = diagnosis.data.values[:, 0], diagnosis.data.seen[:, 0]
    forward = ahead(diagnosis, on_progress)
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
        unexplained=widened_leftover(diagnosis) if diagnosis.effect == "unexplained" else None,
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
    places = tuple(trial.candidate.place for trial in diagnosis.accepted)
    accepted = Explanation(places, diagnosis.accepted[-1].fit)
    rival = next(item.best for item in diagnosis.ranking if item.effect == diagnosis.also[0])
    return distinct(informative_readouts(diagnosis.model, accepted, Explanation((rival.candidate.place,), rival.fit)))


def distinct(tests: list[Advice]) -> tuple[Advice, ...]:
    """The most telling tests, one flight for each motor."""
    kept: dict[str, Advice] = {}
    for test in tests:
        kept.setdefault(test.subject, test)
    return tuple(kept.values())[:MAX_SHOWN_EFFECTS]
