"""The residuals of the plain model, and what they correlate with.

Source: rank correlation by Spearman (1904), analysis of variance of ranks by Kruskal and Wallis (1952). Derivation of
the residuals: the mean over the scales of scatter of leave-one-out residuals in standard deviations.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtrc, stdtr

from fieldkit.flight import CONDITIONS
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.physics.setups import recorded
from fieldkit.scoring.score import forecasts_of
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.patterns import hours
from fieldkit.selection.trial import Trial
from fieldkit.shapes import Array, Flags, Float


@dataclass(frozen=True, slots=True)
class ColumnPattern:
    """Correlation of a readout's residuals with a column of the flights.

    `statistic` is Spearman's rank correlation for numbers and Kruskal and Wallis' H for groups. `p_alone` is the
    p-value of a single test, `p` the p-value corrected for all tests (Holm, 1979).
    """

    against: str
    statistic: float
    p: float
    p_alone: float
    readout: str = "apogee"


@dataclass(frozen=True, slots=True)
class ResidualDistribution:
    """The distribution of one readout's residuals, in units of their expected scatter.

    `bias` and `spread` are mean and standard deviation (0 and 1 if the model is right), and `autocorrelation` is at lag
    1. Each has a p-value: by Student's t, by chi-squared, and by shuffling the flights. nan if fewer than four flights
    have the readout.
    """

    readout: str
    flights: int
    bias: float
    bias_p: float
    spread: float
    spread_p: float
    autocorrelation: float
    autocorrelation_p: float


SHUFFLES = 2000
"""Number of random orders of the flights for the p-value of an autocorrelation. [1]"""


def readout_residuals(diagnosis: Diagnosis) -> Float[Array, "flight readout"]:
    """Every readout of every flight minus its leave-one-out forecast, in expected standard deviations. [1] nan if it
    was not recorded or is not used in the fit.
    """
    return standardised(diagnosis.base.left_out, diagnosis.data.seen)


def standardised(left_out: LeaveOneOut, seen: Flags) -> Float[Array, "flight readout"]:
    """Leave-one-out residuals averaged over the scales of scatter; nan if not observed. [1]"""
    residual = np.einsum("sf,sfo->fo", forecasts_of(left_out).weight, left_out.residual)
    return np.where(seen, residual, np.nan)


def residuals(diagnosis: Diagnosis) -> Float[Array, "flight"]:
    """The residuals of the apogee. [1]"""
    return readout_residuals(diagnosis)[:, 0]


def spreads(diagnosis: Diagnosis) -> list[ResidualDistribution]:
    """Bias, spread and lag-1 autocorrelation of every recorded readout."""
    columns = zip(OBSERVED_READOUTS, readout_residuals(diagnosis).T, strict=True)
    return [spread_of(name, column[np.isfinite(column)]) for name, column in columns if np.isfinite(column).any()]


def spread_of(readout: str, error: Float[Array, "flight"]) -> ResidualDistribution:
    """The distribution of residuals, in the order flown and in their unit, with p-values."""
    count, nan = len(error), float("nan")
    if count < 4 or error.std() == 0:
        return ResidualDistribution(readout, count, float(error.mean()), nan, nan, nan, nan, nan)
    observed = _lag(error)
    shuffled = _lag(np.random.default_rng(0).permuted(np.tile(error, (SHUFFLES, 1)), axis=1))
    centred = shuffled.mean()
    beyond = (np.abs(shuffled - centred) >= abs(observed - centred) - 1e-12).sum()
    return ResidualDistribution(
        readout,
        count,
        float(error.mean()),
        _students_p(float(error.mean() / error.std(ddof=1) * np.sqrt(count)), count - 1),
        float(error.std(ddof=1)),
        _variance_p(error),
        float(observed),
        float((beyond + 1) / (SHUFFLES + 1)),
    )


def _variance_p(error: Float[Array, "flight"]) -> float:
    """Two-sided p-value of a variance by chi-squared. [1]"""
    freedom, squares = len(error) - 1, float(((error - error.mean()) ** 2).sum())
    return 2 * float(min(chdtr(freedom, squares), chdtrc(freedom, squares)))


def _students_p(t: float, freedom: int) -> float:
    """Two-sided p-value of a Student t. [1]"""
    return 2 * float(stdtr(freedom, -abs(t)))


def _lag(error: Float[Array, "*shuffle flight"]) -> Float[Array, "*shuffle"]:
    """Lag-1 autocorrelation. [1]"""
    off = error - error.mean(axis=-1, keepdims=True)
    return np.asarray((off[..., 1:] * off[..., :-1]).sum(axis=-1) / (off**2).sum(axis=-1))


def fingerprint(trial: Trial) -> dict[str, float]:
    """The shift of each readout by an effect at its fitted strength, averaged over its flights.

    Shifts are relative (0.05 is 5% more) except for the time from apogee to ejection [s].
    """
    fit = trial.fit
    mean, _ = fit.moments()
    own = [fit.model.names.index(term.name) for term in trial.candidate.own]
    acts = np.any([term.weight != 0 for term in trial.candidate.own], axis=0)
    shift = (fit.tangent.slope[acts][..., own] @ mean[own]).mean(axis=0)
    return {name: float(value) for name, value in zip(OBSERVED_READOUTS, shift, strict=True)}


def patterns(diagnosis: Diagnosis) -> list[ColumnPattern]:
    """Correlations of every column with the apogee's residuals, the most informative first."""
    return _against(diagnosis, ("apogee",))


def readout_patterns(diagnosis: Diagnosis) -> list[ColumnPattern]:
    """Correlations of every column with the residuals of the other readouts, corrected for all tests together."""
    return _against(diagnosis, OBSERVED_READOUTS[1:])


def _against(diagnosis: Diagnosis, readouts: Sequence[str]) -> list[ColumnPattern]:
    numbers, kinds = columns_of(diagnosis), kinds_of(diagnosis)
    every = readout_residuals(diagnosis)
    found = [
        (name, *test)
        for name in readouts
        for test in associations(every[:, OBSERVED_READOUTS.index(name)], numbers, kinds)
    ]
    corrected = holm([p for *_, p in found])
    rows = [
        ColumnPattern(against, statistic, p, alone, readout)
        for (readout, against, statistic, alone), p in zip(found, corrected, strict=True)
    ]
    return sorted(rows, key=lambda row: (row.p, row.p_alone))


def associations(
    error: Float[Array, "flight"], numbers: Mapping[str, Float[Array, "flight"]], kinds: Mapping[str, Sequence[str]]
) -> list[tuple[str, float, float]]:
    """Each column's name, statistic and uncorrected p-value for some residuals, in any unit; nan is not recorded. A
    group of one flight is left out of the test of its column."""
    seen = np.isfinite(error)
    found: list[tuple[str, float, float]] = []
    for name, values in numbers.items():
        both = seen & np.isfinite(values)
        if both.sum() >= 5 and len(np.unique(values[both])) > 2 and len(np.unique(error[both])) > 1:
            found.append((name, *spearman(values[both], error[both])))
    for name, group in kinds.items():
        own = np.array(group)[seen]
        parts = [error[seen][own == kind] for kind, count in Counter(own.tolist()).items() if count > 1]
        if len(parts) > 1 and len(np.unique(np.concatenate(parts))) > 1:
            found.append((name, *kruskal_wallis(parts)))
    return found


def spearman(one: Float[Array, "flight"], other: Float[Array, "flight"]) -> tuple[float, float]:
    """Spearman's rank correlation and its p-value by Student's t. [1]"""
    freedom = len(one) - 2
    correlation = float(np.corrcoef(ranks(one), ranks(other))[0, 1])
    t = correlation * np.sqrt(freedom / max((1 - correlation) * (1 + correlation), 1e-300))
    return correlation, _students_p(float(t), freedom)


def kruskal_wallis(parts: Sequence[Array]) -> tuple[float, float]:
    """Kruskal and Wallis' H, corrected for ties, and its p-value by chi-squared. [1]"""
    every = ranks(np.concatenate(parts))
    count, ends = len(every), np.cumsum([len(part) for part in parts])[:-1]
    between = sum(float(own.sum()) ** 2 / len(own) for own in np.split(every, ends))
    h = 12 / (count * (count + 1)) * between - 3 * (count + 1)
    _, ties = np.unique(every, return_counts=True)
    h /= 1 - float((ties**3 - ties).sum()) / (count**3 - count)
    return float(h), float(chdtrc(len(parts) - 1, h))


def ranks(values: Float[Array, "flight"]) -> Float[Array, "flight"]:
    """The rank of each value, starting at 1; equal values have their mean rank. [1]"""
    _, kind, count = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - (count - 1) / 2)[kind])


def holm(p: Sequence[float]) -> list[float]:
    """p-values corrected for the probability of any false alarm among all tests (Holm, 1979). [1]"""
    values = np.asarray(p, float)
    order = np.argsort(values, kind="stable")
    stepped = np.maximum.accumulate(values[order] * (len(values) - np.arange(len(values))))
    corrected = np.empty(len(values))
    corrected[order] = np.minimum(stepped, 1.0)
    return [float(value) for value in corrected]


def kinds_of(diagnosis: Diagnosis) -> dict[str, Sequence[str]]:
    """The groups each flight belongs to."""
    model = diagnosis.model
    return {name: model.groups(name) for name in ("motor", "config", "site")}


def columns_of(diagnosis: Diagnosis) -> dict[str, Float[Array, "flight"]]:
    """All recorded numbers of the flights [SI] by header, their flight numbers, hours [h] and expected speeds [m/s]."""
    flights = diagnosis.model.flights
    numbers = {column.header: recorded(flights, column.name) for column in CONDITIONS}
    speed = np.exp(diagnosis.base.fit.tangent.values[:, 1])
    return numbers | {
        "flight_number": np.arange(1.0, len(flights) + 1),
        "hour": hours(flights),
        "expected_top_speed_mps": speed,
    }
