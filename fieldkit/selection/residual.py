"""The residuals of the plain model, and what they correlate with."""

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
    """Correlation of a readout's residuals with a column of the flights.

    `statistic` is Spearman's rank correlation for numbers and Kruskal and Wallis' H for groups; `p_alone` is
    the chance of one as large if nothing is, `p` the same after paying for everything looked at (Holm, 1979).
    """

    against: str
    statistic: float
    p: float
    p_alone: float
    readout: str = "apogee"


@dataclass(frozen=True, slots=True)
class ResidualDistribution:
    """How one readout's residuals are distributed, in units of their expected scatter.

    `bias` and `spread` are mean and standard deviation (0 and 1 if the model is right), `autocorrelation`
    is between one flight and the next. Each comes with the chance of one as far off if the model is right: by
    Student's t, by chi squared, and by shuffling the flights. nan if fewer than four flights have the readout.
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
"""Random orders of the flights that an autocorrelation is compared with. [1]"""


def readout_residuals(diagnosis: Diagnosis) -> Float[Array, "flight readout"]:
    """Every readout of every flight less its forecast from the other flights, in expected standard deviations.

    nan if it was not recorded or is not used in the fit.
    """
    return standardised(diagnosis.base.left_out, diagnosis.data.seen)


def standardised(left_out: LeaveOneOut, seen: Flags) -> Float[Array, "flight readout"]:
    """Residuals of flights left out, averaged over the scales of scatter; nan if nothing was seen."""
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
        _students_p(float(error.mean() / error.std(ddof=1) * np.sqrt(count)), count - 1),
        float(error.std(ddof=1)),
        _variance_p(error),
        float(alike),
        float((beyond + 1) / (SHUFFLES + 1)),
    )


def _variance_p(error: Float[Array, "flight"]) -> float:
    """Chance of a variance as far from one, to either side, by chi squared."""
    from scipy.special import chdtr, chdtrc

    freedom, squares = len(error) - 1, float(((error - error.mean()) ** 2).sum())
    return 2 * float(min(chdtr(freedom, squares), chdtrc(freedom, squares)))


def _students_p(t: float, freedom: int) -> float:
    """Chance of a Student t as far from zero, to either side."""
    from scipy.special import stdtr

    return 2 * float(stdtr(freedom, -abs(t)))


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
    """Every column against the apogee's residuals, the most informative first."""
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
    seen = np.isfinite(error)
    found: list[tuple[str, float, float]] = []
    for name, values in numbers.items():
        both = seen & np.isfinite(values)
        if both.sum() >= 5 and len(np.unique(values[both])) > 2 and len(np.unique(error[both])) > 1:
            found.append((name, *spearman(values[both], error[both])))
    for name, group in kinds.items():
        own = np.array(group)[seen]
        parts = [error[seen][own == kind] for kind in np.unique(own)]
        if len(parts) > 1 and min(len(part) for part in parts) >= 2 and len(np.unique(error[seen])) > 1:
            found.append((name, *kruskal_wallis(parts)))
    return found


def spearman(one: Float[Array, "flight"], other: Float[Array, "flight"]) -> tuple[float, float]:
    """Spearman's rank correlation, and by Student's t the chance of one as strong if there is none."""
    freedom = len(one) - 2
    correlation = float(np.corrcoef(ranks(one), ranks(other))[0, 1])
    t = correlation * np.sqrt(freedom / max((1 - correlation) * (1 + correlation), 1e-300))
    return correlation, _students_p(float(t), freedom)


def kruskal_wallis(parts: Sequence[Array]) -> tuple[float, float]:
    """Kruskal and Wallis' H, corrected for ties, and by chi squared the chance of one as large if groups do not
    differ."""
    from scipy.special import chdtrc

    every = ranks(np.concatenate(parts))
    count, ends = len(every), np.cumsum([len(part) for part in parts])[:-1]
    between = sum(float(own.sum()) ** 2 / len(own) for own in np.split(every, ends))
    h = 12 / (count * (count + 1)) * between - 3 * (count + 1)
    _, ties = np.unique(every, return_counts=True)
    h /= 1 - float((ties**3 - ties).sum()) / (count**3 - count)
    return float(h), float(chdtrc(len(parts) - 1, h))


def ranks(values: Float[Array, "flight"]) -> Float[Array, "flight"]:
    """The rank of each value from one on, the mean of theirs if several are equal."""
    _, kind, count = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - (count - 1) / 2)[kind])


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
