"""Fast forecast of the next flight: the history network and one linear pass, without a fit."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fieldkit.flight import Flight
from fieldkit.flight.plan import repeated
from fieldkit.inference.history.features import PreparedHistory, modeled, summarized
from fieldkit.inference.history.response import respond
from fieldkit.inference.network.history import QuickAnswer, answers, load_history, prepared
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found
from fieldkit.physics.history import History, flown_and_planned, together
from fieldkit.selection.quick_candidates import quick_candidates

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

BATCH = 50
"""Number of separate flights whose response is computed in one batch of about 5,000 simulations. [1]"""


def prepare_at_once(
    flown: FlownFlights,
    plans: FlownFlights,
    used_in_fit: Sequence[bool],
    *,
    shared: SharedPrior | None = None,
) -> PreparedHistory:
    """The part of a history that does not depend on readouts, from a rocket's flights in the order flown, at least one,
    and plans.

    `shared` is the information from the flyer's other rockets. Raises ImpossibleFlight for a flight without a dry mass,
    DamagedModel if the hyperprior cannot be read, BadValue for a recovery figure or rail direction that cannot be read.
    """
    return prepared(_history(flown, plans).using(used_in_fit), quick_candidates, shared)


def _history(flown: FlownFlights, plans: FlownFlights) -> History:
    named = [  # a place without a start has an empty id, which a plan must not share
        (flight if flight.flight_id else flight.with_changes(flight_id="planned"), motor) for flight, motor in plans
    ]
    return flown_and_planned(flown, named)


def answer_at_once(
    ready: PreparedHistory, flown: Sequence[Flight], ensemble: "Ensemble | None" = None
) -> list[QuickAnswer]:
    """The network's answer for each plan of a prepared history, with the current readouts of its flown flights.

    Raises DamagedModel if the network cannot be loaded.
    """
    network = ensemble or load_history()
    return answers(summarized(ready, flown, tuple(network.card["effects"])), network)


def forecast_at_once(
    flown: FlownFlights,
    plan: tuple[Flight, Found],
    *,
    shared: SharedPrior | None = None,
    ensemble: "Ensemble | None" = None,
) -> QuickAnswer:
    """The network's forecast of a plan from the flights of its rocket in the order flown, at least one.

    Flights with an anomaly tag count as flown and are not used. Other arguments and errors as in `prepare_at_once`.
    """
    ready = prepared(_history(flown, [plan]), quick_candidates, shared)
    return answer_at_once(ready, ready.flown, ensemble)[0]


def forecasts_at_once(
    flown: FlownFlights,
    plans: FlownFlights,
    *,
    shared: SharedPrior | None = None,
    ensemble: "Ensemble | None" = None,
) -> list[QuickAnswer]:
    """The network's forecasts of alternative plans that differ only in their motors, in their order.

    All are simulated in one batch; motors flown before and new ones are summarized separately. Other arguments and
    errors as in `forecast_at_once`.
    """
    whole, before = _history(flown, plans), list(range(len(flown)))
    kinds = whole.groups("motor")
    known, new = set(kinds[: len(flown)]), kinds[len(flown) :]
    flown_or_new = [[row for row, kind in enumerate(new) if (kind in known) is old] for old in (True, False)]
    groups_of_rows = [rows for rows in flown_or_new if rows]
    models = [
        modeled(_history(flown, [plans[row] for row in rows]), quick_candidates, shared) for rows in groups_of_rows
    ]
    response = respond(whole, {name for own in models for name in own.acting})
    found: dict[int, QuickAnswer] = {}
    for rows, own in zip(groups_of_rows, models, strict=True):
        ready = PreparedHistory(own, response.part([*before, *(len(flown) + row for row in rows)]))
        found |= dict(zip(rows, answer_at_once(ready, ready.flown, ensemble), strict=True))
    return [found[row] for row in range(len(plans))]


def each_at_once(flown: FlownFlights, shared: Sequence[SharedPrior | None]) -> list[QuickAnswer]:
    """The network's answer for each single flight, of any rockets, with the plan to repeat it.

    `shared` is the information from the other rockets of each flyer. Flights are simulated in batches. Flights with an
    anomaly tag are used like any other. Other arguments and errors as in `forecast_at_once`.
    """
    found: list[QuickAnswer] = []
    for first in range(0, len(flown), BATCH):
        batch = flown[first : first + BATCH]
        theirs = shared[first : first + BATCH]
        pairs = [_history([one], [(repeated(one[0]), one[1])]).using([True]) for one in batch]
        models = [modeled(pair, quick_candidates, own) for pair, own in zip(pairs, theirs, strict=True)]
        response = respond(together(pairs), {name for own in models for name in own.acting})
        for number, own in enumerate(models):
            ready = PreparedHistory(own, response.part(slice(2 * number, 2 * number + 2)))
            found += answer_at_once(ready, ready.flown)
    return found
