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
    known = {id(item.motor) for _, item in history}
    stranger = next(motor for motor in (_typical(motors, history)) if id(motor) not in known)
    return learn(history, plan, Found(stranger, None), accepted_places(ledger, plan.rocket), draws=draws)


def _typical(motors: Catalogue, history: list[tuple[Flight, Found]]):  # type: ignore[no-untyped-def]
    """Motors by how close their impulse is to the last flown, so that the stand-in flies like those asked for."""
    impulse = history[-1][1].motor.total_impulse if history else 40.0
    return sorted(motors.motors, key=lambda motor: (abs(motor.total_impulse - impulse), motor.designation))
