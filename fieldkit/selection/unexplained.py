"""Patterns that no known effect explains: a sentence with what they correlate with, and their size."""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.selection.candidates import ORDINALS, Pattern
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.recorded_columns import column_in_words, value_in_words
from fieldkit.selection.residual import columns_of, kinds_of, patterns
from fieldkit.shapes import Array, Flags, Float


@dataclass(frozen=True, slots=True)
class Leftover:
    """Flights that differ from the others: which ones, by what fraction of the apogee, and its standard deviation.

    `amount` and `sd` refer to a ratio of apogees minus one; `where` marks the flights. Those with a high number in a
    column have its header as `column`, and are those above `bound` [SI]. Without a `name`, misses follow nothing.
    """

    name: str
    where: Flags
    amount: float
    sd: float
    column: str = ""
    bound: float = 0.0

    @property
    def in_words(self) -> str:
        """The pattern in SI units."""
        return self.words()

    def words(self, system: str = "SI") -> str:
        """`the 3 flights with wind above 4.5 m/s fly 6% higher than the others (± 2%)`, in the units of a system."""
        count = int(self.where.sum())
        if not count:
            return f"misses follow {self.name or 'nothing that was recorded'}"
        name = self.name
        if self.column:
            name = f"with {column_in_words(self.column)} above {value_in_words(self.column, self.bound, system)}"
        who = f"the {count} flights" if count > 1 else "the one flight"
        verb = "fly" if count > 1 else "flies"
        way = "higher" if self.amount > 0 else "lower"
        return f"{who} {name} {verb} {abs(self.amount):.0%} {way} than the others (± {self.sd:.0%})"


def leftover(diagnosis: Diagnosis) -> Leftover:
    """The unexplained pattern in a sentence; a difference that is within its error is none."""
    nothing = Leftover("", np.zeros(len(diagnosis.model.flights), bool), 0.0, 0.0)
    found = _goes_with(diagnosis)
    return found if found and (not found.where.any() or abs(found.amount) > found.sd) else nothing


def _goes_with(diagnosis: Diagnosis) -> Leftover | None:
    """What the apogee's residuals follow most: the strongest pattern, or else the most informative column."""
    error = _shares(diagnosis)
    best = next((item for item in diagnosis.ranking if not item.effect), None)
    pattern = best.best.candidate.place.pattern if best else None
    if best and pattern and best.probability > 0.5:
        weight = best.best.candidate.terms[0].weight
        if pattern.smooth:
            return Leftover(pattern.in_words, np.zeros(len(error), bool), 0.0, 0.0)
        sorts = set(np.unique(weight)) <= {0.0, 1.0}
        name = _pattern_words(pattern) if sorts or pattern.kind == "hour" else f"with {pattern} above its median"
        return _compared(name, weight > (0 if sorts else np.median(weight)), error)
    for row in patterns(diagnosis)[:1]:
        if row.against in (numbers := columns_of(diagnosis)):
            values = numbers[row.against]
            middle = float(np.nanmedian(values))
            found = _compared(row.against, values > middle, error)
            return found and replace(found, column=row.against, bound=middle)
        kinds = np.array(kinds_of(diagnosis)[row.against])
        candidates = [
            _compared(f"with {column_in_words(row.against)} {kind}", kinds == kind, error) for kind in np.unique(kinds)
        ]
        described = [one for one in candidates if one is not None]
        return max(described, key=lambda one: abs(one.amount) / max(one.sd, 1e-6), default=None)
    return None


def _shares(diagnosis: Diagnosis) -> Float[Array, "flight"]:
    """Leave-one-out log ratio of flown to predicted apogee of each flight; nan if it is not used in the fit."""
    seen = diagnosis.data.seen[:, 0]
    return np.where(seen, diagnosis.data.values[:, 0] - np.log(diagnosis.forecasts_before.apogee), np.nan)


def _compared(name: str, inside: Flags, error: Float[Array, "flight"]) -> Leftover | None:
    one, other = error[inside & np.isfinite(error)], error[~inside & np.isfinite(error)]
    if not len(one) or not len(other):
        return None
    pooled = np.sqrt(np.nanvar(np.concatenate([one - one.mean(), other - other.mean()]), ddof=2))
    sd = float(pooled * np.sqrt(1 / len(one) + 1 / len(other)))
    return Leftover(name, inside & np.isfinite(error), float(np.expm1(one.mean() - other.mean())), sd)


def _pattern_words(pattern: Pattern) -> str:
    match pattern.kind:
        case "site":
            return f"from {pattern.of}"
        case "day":
            return f"on {pattern.of}"
        case "hour":
            return "later in the day"
        case "lasting":
            return f"from {pattern.of} on"
        case "repeated":
            return f"in every {ORDINALS[pattern.every]} place, {pattern.of} among them,"
        case _:
            return f"with {pattern}"
