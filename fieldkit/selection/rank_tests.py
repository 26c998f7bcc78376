"""Whether values go together: rank tests and a few distributions, on scipy.special alone.

They are those of `scipy.stats` (a test compares them), whose import takes longer than a loop has to spare.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.shapes import Array, Float


def student_p(t: float, freedom: float) -> float:
    """Chance of a Student t as far from zero, to either side."""
    from scipy.special import stdtr

    return float(2 * stdtr(freedom, -abs(t)))


def spread_p(sum_of_squares: float, freedom: float) -> float:
    """Chance of a sum of squared standard normals as far out, to either side."""
    from scipy.special import chdtr

    tail = float(chdtr(freedom, sum_of_squares))
    return 2 * min(tail, 1 - tail)


def ranks(values: Float[Array, "flight"]) -> Float[Array, "flight"]:
    """Ranks from 1, equal values sharing the middle of theirs."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - (count - 1) / 2)[place])


def spearman(one: Float[Array, "flight"], other: Float[Array, "flight"]) -> tuple[float, float]:
    """Rank correlation, and its chance where nothing is: by Student's t (Kendall and Stuart, 1973, 31.19)."""
    correlation = float(np.corrcoef(ranks(one), ranks(other))[0, 1])
    freedom = len(one) - 2
    rest = 1 - correlation**2
    return correlation, student_p(correlation * np.sqrt(freedom / rest), freedom) if rest > 1e-15 else 0.0


def kruskal(groups: Sequence[Float[Array, "_"]]) -> tuple[float, float]:
    """Kruskal and Wallis' H, corrected for ties, and its chance where nothing is (J. Am. Stat. Assoc. 47, 1952)."""
    from scipy.special import chdtrc

    every = np.concatenate(groups)
    count = len(every)
    parts = np.split(ranks(every), np.cumsum([len(group) for group in groups])[:-1])
    h = 12 / (count * (count + 1)) * sum(part.sum() ** 2 / len(part) for part in parts) - 3 * (count + 1)
    _, tied = np.unique(every, return_counts=True)
    h /= 1 - (tied**3 - tied).sum() / (count**3 - count)
    return float(h), float(chdtrc(len(groups) - 1, h))
