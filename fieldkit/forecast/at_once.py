"""The next flight at once: the forecast of the network of whole histories, with no fit beside one linear pass."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fieldkit.flight import Flight
from fieldkit.inference.history.records import History
from fieldkit.inference.network.history import QuickAnswer, quick_answer
from fieldkit.model.hyperprior import Hyperprior, certified, learned
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found
from fieldkit.selection.quick_candidates import quick_candidates

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble


def forecast_at_once(
    flown: Sequence[tuple[Flight, Found]],
    plan: tuple[Flight, Found],
    *,
    shared: SharedPrior | None = None,
    hyperprior: Hyperprior | None = None,
    ensemble: "Ensemble | None" = None,
) -> QuickAnswer:
    """What the network forecasts of a plan from the flights of its rocket, in the order flown; at least one of them.

    Flights with an anomaly tag count as flown and are not used. `shared` is what the flyer's other rockets show,
    `hyperprior` by default the learned one. Raises ImpossibleFlight for a flight without a dry mass.
    """
    flight, motor = plan
    name = flight.flight_id or "planned"  # a plan without a name would be where places without a beginning begin
    both = [*flown, (flight.with_changes(flight_id=name), motor)]
    history = History(
        tuple(one for one, _ in both),
        tuple(found for _, found in both),
        tuple(one.clean for one, _ in flown),
        certified(),
        hyperprior or learned(),
        shared,
    )
    return quick_answer(history, quick_candidates, ensemble)
