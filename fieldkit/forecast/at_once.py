"""The next flight at once: the forecast of the network of whole histories, with no fit except one linear pass."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.start import repeated
from fieldkit.inference.history.features import PreparedHistory, prepared, summarized
from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.records import History
from fieldkit.inference.history.response import respond
from fieldkit.inference.network.history import QuickAnswer, answers, load_history, response_of, trained_prior
from fieldkit.model.hyperprior import certified, learned
from fieldkit.model.rocket_model import groups, reference_area
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found
from fieldkit.selection.quick_candidates import quick_candidates

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

FlownFlights = Sequence[tuple[Flight, Found]]
BATCH = 50
"""Flights by themselves whose response is simulated together: some 5,000 simulated flights. [1]"""


def prepare_at_once(
    flown: FlownFlights,
    plans: FlownFlights,
    used_in_fit: Sequence[bool],
    *,
    shared: SharedPrior | None = None,
    ensemble: "Ensemble | None" = None,
) -> PreparedHistory:
    """Flights of a rocket in the order flown, at least one, and plans, as far as readouts do not matter.

    `shared` is what the flyer's other rockets show. Raises ImpossibleFlight for a flight without a dry mass.
    """
    history = _history(flown, plans, used_in_fit, shared, ensemble)
    return prepared(history, response_of(history), quick_candidates)


def _history(
    flown: FlownFlights,
    plans: FlownFlights,
    used_in_fit: Sequence[bool],
    shared: SharedPrior | None,
    ensemble: "Ensemble | None",
) -> History:
    named = [  # a plan without a name would be where places without a beginning begin
        (flight if flight.flight_id else flight.with_changes(flight_id="planned"), motor) for flight, motor in plans
    ]
    flights, found = zip(*flown, *named, strict=True)
    return History(flights, found, tuple(used_in_fit), certified(), trained_prior(ensemble), shared)


def fit_in_use(ready: PreparedHistory) -> LinearFit:
    """The linear fit of a prepared history by the hyperprior that forecasts are made with now, which may have been
    learned after the network was trained."""
    again = prepared(replace(ready.history, forecast=learned()), ready.response, quick_candidates)
    return summarized(again, again.flown, ()).forecast


def answer_at_once(
    ready: PreparedHistory, flown: Sequence[Flight], ensemble: "Ensemble | None" = None
) -> list[QuickAnswer]:
    """What the network says of each plan of a prepared history, its flown flights with the readouts they have now."""
    network = ensemble or load_history()
    return answers(summarized(ready, flown, tuple(network.card["effects"])), network)


def forecast_at_once(
    flown: FlownFlights,
    plan: tuple[Flight, Found],
    *,
    shared: SharedPrior | None = None,
    ensemble: "Ensemble | None" = None,
) -> QuickAnswer:
    """What the network forecasts of a plan from the flights of its rocket, in the order flown; at least one of them.

    Flights with an anomaly tag count as flown and are not used. The rest is as in `prepare_at_once`.
    """
    used = [flight.clean for flight, _ in flown]
    ready = prepare_at_once(flown, [plan], used, shared=shared, ensemble=ensemble)
    return answer_at_once(ready, ready.flown, ensemble)[0]


def forecasts_at_once(
    flown: FlownFlights,
    plans: FlownFlights,
    *,
    shared: SharedPrior | None = None,
    ensemble: "Ensemble | None" = None,
) -> list[QuickAnswer]:
    """What the network forecasts of plans that differ in their motors alone, each as if it flew next, in their order.

    All fly in one batch; motors that the rocket flew and others are summarized apart. The rest as `forecast_at_once`.
    """
    known = set(groups([flight for flight, _ in flown], [motor for _, motor in flown], "motor"))
    kinds = groups([flight for flight, _ in plans], [motor for _, motor in plans], "motor")
    used, before = [flight.clean for flight, _ in flown], list(range(len(flown)))
    response = response_of(_history(flown, plans, used, shared, ensemble))
    found: dict[int, QuickAnswer] = {}
    for old in (True, False):
        rows = [row for row, kind in enumerate(kinds) if (kind in known) is old]
        if rows:
            history = _history(flown, [plans[row] for row in rows], used, shared, ensemble)
            own = response.part([*before, *(len(flown) + row for row in rows)])
            ready = prepared(history, own, quick_candidates)
            found |= dict(zip(rows, answer_at_once(ready, ready.flown, ensemble), strict=True))
    return [found[row] for row in range(len(plans))]


def each_at_once(
    flown: FlownFlights,
    shared: Sequence[SharedPrior | None],
    *,
    ensemble: "Ensemble | None" = None,
) -> list[QuickAnswer]:
    """What the network says of each flight by itself, of any rockets, for the plan to fly the same again.

    `shared` is what the other rockets of each one's flyer show. All fly in batches. Flights with an anomaly tag are
    used like any other. The rest as `forecast_at_once`.
    """
    found: list[QuickAnswer] = []
    for first in range(0, len(flown), BATCH):
        batch = flown[first : first + BATCH]
        theirs = shared[first : first + BATCH]
        pairs = [
            _history([one], [(repeated(one[0]), one[1])], (True,), own, ensemble)
            for one, own in zip(batch, theirs, strict=True)
        ]
        response = respond(
            [pair.flights[row] for row in (0, 1) for pair in pairs],
            [pair.found[row] for row in (0, 1) for pair in pairs],
            np.array([reference_area(pair.flights, 1)[row] for row in (0, 1) for pair in pairs]),
        )
        for number, pair in enumerate(pairs):
            ready = prepared(pair, response.part([number, len(pairs) + number]), quick_candidates)
            found += answer_at_once(ready, ready.flown, ensemble)
    return found
