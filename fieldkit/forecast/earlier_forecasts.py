"""The next forecast corrected by the results of the flyer's earlier forecasts.

If a simpler method has forecast the earlier flights better than the model, the next forecast is a mixture of the two
(`fieldkit.forecast.evaluation.stacking`). Then its interval is stretched to the coverage that earlier intervals had
(`fieldkit.forecast.conformal`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.rivals import rival_draws
from fieldkit.forecast.evaluation.stacking import MODEL_ALONE, STACKED_RIVALS, mixed_in
from fieldkit.forecast.evaluation.uncalibrated import simulate
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class EarlierForecasts:
    """The results of a flyer's earlier forecasts: how many there are, the factor on the width of the next interval
    (None with too few), and the stacking weights of the model and of `STACKED_RIVALS` for a rocket that has flown and
    for a first flight, the next one of a rocket without an apogee. [1]

    `flown` are the flights of all rockets in the order flown, from which the rivals forecast.
    """

    count: int = 0
    stretch: float | None = None
    weights: tuple[float, ...] = MODEL_ALONE
    weights_of_first: tuple[float, ...] = MODEL_ALONE
    flown: tuple[tuple[Flight, Found], ...] = ()

    def corrected(self, made: Sequence[Prediction]) -> list[Prediction]:
        """Predictions of alternative plans, each mixed with its rivals' and then stretched."""
        return [one.corrected(self.stretch, self.count) for one in self._mixed(made)]

    def _mixed(self, made: Sequence[Prediction]) -> Sequence[Prediction]:
        known = {flight.rocket for flight, _ in self.flown if flight.clean and flight.apogee is not None}
        weights = [self.weights if one.plan.rocket in known else self.weights_of_first for one in made]
        if all(one == MODEL_ALONE for one in weights):
            return made
        earlier = [one for one in simulate(self.flown) if one.flight.clean and one.flight.apogee is not None]
        plans = simulate([(one.plan, one.found) for one in made])
        rivals = [rival_draws(earlier, plan) for plan in plans]
        return [_mixture(*each) for each in zip(made, rivals, weights, strict=True)]


def _mixture(made: Prediction, rivals: Mapping[str, Float[Array, "_"]], weights: Sequence[float]) -> Prediction:
    shares = dict(zip(STACKED_RIVALS, weights[1:], strict=True))
    used = {name: share for name, share in shares.items() if share and len(rivals.get(name, ())) > 1}
    return made.mixed(mixed_in(made.apogee, rivals, weights), used) if used else made
