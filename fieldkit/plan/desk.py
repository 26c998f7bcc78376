"""Plans for a rocket of a ledger, asked for by name."""

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.loop.desk import accepted_places, completed, flown
from fieldkit.motors import Catalogue, Found
from fieldkit.plan.learnt import DRAWS, Learnt, learn


def learn_rocket(ledger: Ledger, motors: Catalogue, plan: Flight, *, draws: int = DRAWS) -> Learnt:
    """What the flights of the plan's rocket taught, with what the plan leaves out taken from the last of them.

    Raises ImpossibleFlight where neither has a dry mass.
    """
    history = flown(ledger, motors, plan.rocket)
    plan = completed(plan, [flight for flight, _ in history])
    return learn(history, plan, _stranger(motors, history), accepted_places(ledger, plan.rocket), draws=draws)


def _stranger(motors: Catalogue, history: list[tuple[Flight, Found]]) -> Found:
    """A motor that was not flown, of the class that was flown last: it stands for all the others."""
    known = {id(item.motor) for _, item in history}
    letter = history[-1][1].motor.name[:1] if history else "F"
    every = [listing for listings in motors.shelf.values() for listing in listings]
    likely = sorted(every, key=lambda listing: (listing.name[:1] != letter, not listing.available, listing.label))
    return Found(next(motor for listing in likely if id(motor := listing.motor()) not in known), None)
