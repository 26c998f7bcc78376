"""Fast forecasts of the next flight from one linear pass, without a fit."""

from collections.abc import Mapping, Sequence

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.plan import repeated
from fieldkit.inference.history.linear_fit import PreparedFit
from fieldkit.inference.history.quick_forecast import (
    PreparedHistory,
    QuickAnswer,
    acting,
    answers,
    around_reference,
    modeled,
    posterior_center,
    prepared,
)
from fieldkit.inference.history.response import off_reference, reference, respond
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found
from fieldkit.physics.history import History, flown_and_planned, together
from fieldkit.shapes import Array, Float

BATCH = 50
"""Number of separate flights whose response is computed in one batch. [1]"""


def prepare_at_once(
    flown: FlownFlights, plans: FlownFlights, used_in_fit: Sequence[bool], *, shared: SharedPrior | None = None
) -> PreparedHistory:
    """The part of a history that does not depend on readouts, from a rocket's flights in the order flown, at least one,
    and plans.

    `shared` is the information from the flyer's other rockets. Raises ImpossibleFlight for a flight without a dry mass,
    DamagedModel if the hyperprior cannot be read.
    """
    return prepared(_history(flown, plans).using(used_in_fit), shared)


def _history(flown: FlownFlights, plans: FlownFlights) -> History:
    named = [  # a place without a start has an empty id, which a plan must not share
        (flight if flight.flight_id else flight.with_changes(flight_id="planned"), motor) for flight, motor in plans
    ]
    return flown_and_planned(flown, named)


def forecast_at_once(
    flown: FlownFlights, plan: tuple[Flight, Found], *, shared: SharedPrior | None = None
) -> QuickAnswer:
    """The forecast of a plan from the flights of its rocket in the order flown, at least one.

    Flights with an anomaly tag count as flown and are not used. Other arguments and errors as in `prepare_at_once`.
    """
    ready = prepared(_history(flown, [plan]), shared)
    return answers(ready, ready.flown)[0]


def forecasts_at_once(
    flown: FlownFlights, plans: FlownFlights, *, shared: SharedPrior | None = None
) -> list[QuickAnswer]:
    """The forecasts of alternative plans that differ only in their motors, in their order.

    All are simulated in one batch; motors flown before and new ones are answered separately. Other arguments and errors
    as in `forecast_at_once`.
    """
    whole, before = _history(flown, plans), list(range(len(flown)))
    kinds = whole.groups("motor")
    known, new = set(kinds[: len(flown)]), kinds[len(flown) :]
    flown_or_new = [[row for row, kind in enumerate(new) if (kind in known) is old] for old in (True, False)]
    groups_of_rows = [rows for rows in flown_or_new if rows]
    histories = [_history(flown, [plans[row] for row in rows]) for rows in groups_of_rows]
    fits = [modeled(history, shared) for history in histories]
    first = around_reference(_history(flown, [plans[groups_of_rows[0][0]]]), shared)
    known_at = dict(zip(first.fit.model.names, posterior_center(first), strict=True))
    places = [[*before, *(len(flown) + row for row in rows)] for rows in groups_of_rows]
    centers = [_center(fit, known_at) for fit in fits]
    found: dict[int, QuickAnswer] = {}
    for rows, ready in zip(groups_of_rows, _simulated(whole, places, histories, fits, centers), strict=True):
        found |= dict(zip(rows, answers(ready, ready.flown), strict=True))
    return [found[row] for row in range(len(plans))]


def _center(fit: PreparedFit, known: Mapping[TermName, float]) -> Float[Array, "term"]:
    """The values of a fit's terms around which its flights are simulated: the `known` ones, else the reference."""
    at = zip(fit.model.names, reference(fit.model), strict=True)
    return np.array([known.get(name, usual) for name, usual in at])


def _simulated(
    whole: History,
    places: Sequence[list[int]],
    parts: Sequence[History],
    fits: Sequence[PreparedFit],
    centers: Sequence[Float[Array, "term"]],
) -> list[PreparedHistory]:
    """Several histories, at some `places` of a whole one, prepared around some values of their terms from one batch of
    simulated flights."""
    around: dict[str, Float[Array, "flight"]] = {}
    for place, fit, center in zip(places, fits, centers, strict=True):
        for kind, off in off_reference(fit.model, center).items():
            around.setdefault(kind, np.zeros(len(whole.flights)))[place] = off
    response = respond(whole, {name for fit in fits for name in acting(fit)}, around)
    return [
        PreparedHistory(part, fit, response.part(place), center)
        for part, fit, place, center in zip(parts, fits, places, centers, strict=True)
    ]


def each_at_once(flown: FlownFlights, shared: Sequence[SharedPrior | None]) -> list[QuickAnswer]:
    """The answer for each single flight, of any rockets, with the plan to repeat it.

    `shared` is the information from the other rockets of each flyer. Flights are simulated in batches. Flights with an
    anomaly tag are used like any other. There is one pass, around the reference, because a second one makes no estimate
    of drag better (`python -m bench.infer`). Other arguments and errors as in `forecast_at_once`.
    """
    found: list[QuickAnswer] = []
    for first in range(0, len(flown), BATCH):
        pairs = [_history([one], [(repeated(one[0]), one[1])]).using([True]) for one in flown[first : first + BATCH]]
        fits = [modeled(pair, own) for pair, own in zip(pairs, shared[first : first + BATCH], strict=True)]
        places = [[2 * row, 2 * row + 1] for row in range(len(pairs))]
        for ready in _simulated(together(pairs), places, pairs, fits, [reference(fit.model) for fit in fits]):
            found += answers(ready, ready.flown, causes=False)
    return found
