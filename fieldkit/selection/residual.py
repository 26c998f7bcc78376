"""What the plain model gets wrong, and what the errors go together with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import CONDITIONS
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import groups
from fieldkit.physics.setups import recorded
from fieldkit.scoring.score import forecasts_of
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.trial import Trial
from fieldkit.shapes import Array, Flags, Float


@dataclass(frozen=True, slots=True)
class Pattern:
    """How strongly a readout's residuals go together with a column of the flights.

    `statistic` is Spearman's rank correlation for numbers and Kruskal and Wallis' H for groups; `p_alone` is
    the chance of one as large where nothing is, `p` the same after paying for everything looked at (Holm, 1979).
    """

    against: str
    statistic: float
    p: float
    p_alone: float
    readout: str = "apogee"


@dataclass(frozen=True, slots=True)
class ResidualDistribution:
    """How one readout's residuals are distributed, in units of their expected scatter.

    `bias` and `spread` are mean and standard deviation (0 and 1 where the model is right), `autocorrelation`
    is between one flight and the next. Each comes with the chance of one as far off where the model is right: by
    Student's t, by chi squared, and by shuffling the flights. nan where fewer than four flights have the readout.
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
"""Orders of the flights that an autocorrelation is compared with."""


def readout_residuals(diagnosis: Diagnosis) -> Float[Array, "flight readout"]:
    """Every readout of every flight less its forecast from the other flights, in expected standard deviations.

    nan where it was not recorded or does not teach.
    """
    return standardised(diagnosis.base.left_out, diagnosis.data.seen)


def standardised(left_out: LeaveOneOut, seen: Flags) -> Float[Array, "flight readout"]:
    """Residuals of flights left out, averaged over the scales of scatter; nan where nothing was seen."""
    residual = np.einsum("sf,sfo->fo", forecasts_of(left_out).weight, left_out.residual)
    return np.where(seen, residual, np.nan)


def residuals(diagnosis: Diagnosis) -> Float[Array, "flight"]:
    """The apogee's residuals alone."""
    return readout_residuals(diagnosis)[:, 0]


def spreads(diagnosis: Diagnosis) -> list[ResidualDistribution]:
    """Bias, spread and autocorrelation in time of every readout that was recorded."""
    columns = zip(OBSERVED_READOUTS, readout_residuals(diagnosis).T, strict=True)
    return [spread_of(name, column[np.isfinite(column)]) for name, column in columns if np.isfinite(column).any()]


def spread_of(readout: str, error: Float[Array, "flight"]) -> ResidualDistribution:
    """How residuals in the order flown are distributed, and how likely that is by chance."""
    from scipy.stats import ttest_1samp

    count, nan = len(error), float("nan")
    if count < 4 or error.std() == 0:
        return ResidualDistribution(readout, count, float(error.mean()), nan, nan, nan, nan, nan)
    alike = _lag(error)
    shuffled = _lag(np.random.default_rng(0).permuted(np.tile(error, (SHUFFLES, 1)), axis=1))
    centred = shuffled.mean()
    beyond = (np.abs(shuffled - centred) >= abs(alike - centred) - 1e-12).sum()
    return ResidualDistribution(
        readout,
        count,
        float(error.mean()),
        float(ttest_1samp(error, 0.0).pvalue),
        float(error.std(ddof=1)),
        _variance_p(error),
        float(alike),
        float((beyond + 1) / (SHUFFLES + 1)),
    )


def _variance_p(error: Float[Array, "flight"]) -> float:
    """Chance of a variance as far from one, to either side, by chi squared."""
    from scipy.stats import chi2

    around_mean = chi2(len(error) - 1)
    squares = float(((error - error.mean()) ** 2).sum())
    return 2 * float(min(around_mean.cdf(squares), around_mean.sf(squares)))


def _lag(error: Float[Array, "*shuffle flight"]) -> Float[Array, "*shuffle"]:
    """Correlation between one flight and the next."""
    off = error - error.mean(axis=-1, keepdims=True)
    return np.asarray((off[..., 1:] * off[..., :-1]).sum(axis=-1) / (off**2).sum(axis=-1))


def fingerprint(trial: Trial) -> dict[str, float]:
    """What an effect at its fitted strength does to each readout, averaged over the flights it acts on.

    By ratio (0.05 is 5 % more) for all but apogee to ejection, which is in seconds.
    """
    fit = trial.fit
    mean, _ = fit.moments()
    own = [fit.model.names.index(term.name) for term in trial.candidate.terms]
    acts = np.any([term.weight != 0 for term in trial.candidate.terms], axis=0)
    shift = (fit.tangent.slope[acts][..., own] @ mean[own]).mean(axis=0)
    return {name: float(value) for name, value in zip(OBSERVED_READOUTS, shift, strict=True)}


def patterns(diagnosis: Diagnosis) -> list[Pattern]:
    """Every column against the apogee's residuals, the most telling first."""
    return _against(diagnosis, ("apogee",))


def readout_patterns(diagnosis: Diagnosis) -> list[Pattern]:
    """Every column against the residuals of the other readouts, corrected over all of them together."""
    return _against(diagnosis, OBSERVED_READOUTS[1:])


def _against(diagnosis: Diagnosis, readouts: Sequence[str]) -> list[Pattern]:
    numbers, kinds = columns_of(diagnosis), kinds_of(diagnosis)
    every = readout_residuals(diagnosis)
    found = [
        (name, *test)
        for name in readouts
        for test in associations(every[:, OBSERVED_READOUTS.index(name)], numbers, kinds)
    ]
    corrected = holm([p for *_, p in found])
    rows = [
        Pattern(against, statistic, p, alone, readout)
        for (readout, against, statistic, alone), p in zip(found, corrected, strict=True)
    ]
    return sorted(rows, key=lambda row: (row.p, row.p_alone))


def associations(
    error: Float[Array, "flight"], numbers: Mapping[str, Array], kinds: Mapping[str, Sequence[str]]
) -> list[tuple[str, float, float]]:
    """Each column's name, statistic and uncorrected p against residuals; nan is not recorded."""
    from scipy.stats import kruskal, spearmanr

    seen = np.isfinite(error)
    found: list[tuple[str, float, float]] = []
    for name, values in numbers.items():
        both = seen & np.isfinite(values)
        if both.sum() >= 5 and len(np.unique(values[both])) > 2 and len(np.unique(error[both])) > 1:
            ranks = spearmanr(values[both], error[both])
            found.append((name, float(ranks.statistic), float(ranks.pvalue)))
    for name, group in kinds.items():
        own = np.array(group)[seen]
        parts = [error[seen][own == kind] for kind in np.unique(own)]
        if len(parts) > 1 and min(len(part) for part in parts) >= 2 and len(np.unique(error[seen])) > 1:
            apart = kruskal(*parts)
            found.append((name, float(apart.statistic), float(apart.pvalue)))
    return found


def holm(p: Sequence[float]) -> list[float]:
    """Chances corrected so that even one false alarm among all of them is as rare as said (Holm, 1979)."""
    values = np.asarray(p, float)
    order = np.argsort(values, kind="stable")
    stepped = np.maximum.accumulate(values[order] * (len(values) - np.arange(len(values))))
    corrected = np.empty(len(values))
    corrected[order] = np.minimum(stepped, 1.0)
    return [float(value) for value in corrected]


def kinds_of(diagnosis: Diagnosis) -> dict[str, Sequence[str]]:
    """The groups each flight belongs to."""
    model = diagnosis.model
    return {name: groups(model.flights, model.found, name) for name in ("motor", "config", "site")}


def columns_of(diagnosis: Diagnosis) -> dict[str, Array]:
    """Everything written down of the flights in numbers, and their number, hour and expected speed."""
    flights = diagnosis.model.flights
    hours = [f.date_time.hour + f.date_time.minute / 60 if f.date_time else np.nan for f in flights]
    numbers = {column.header: recorded(flights, column.name) for column in CONDITIONS}
    speed = np.exp(diagnosis.base.fit.tangent.values[:, 1])
    return numbers | {
        "flight_number": np.arange(1.0, len(flights) + 1),
        "hour": np.array(hours, float),
        "expected_top_speed_mps": speed,
    }
