"""A quick look at a rocket of a ledger: the network's probabilities of what its model lacks, and nothing is kept."""

from fieldkit.errors import NoFlights
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.selection.quick_look import QuickLook, quick_look
from fieldkit.services.forecasts import flown

MIN_FLIGHTS = 4
"""Clean flights with an apogee that a look needs, as closing the loop does. [1]"""


def look_quickly(ledger: Ledger, motors: Catalogue, rocket: str) -> QuickLook:
    """What the network of whole histories makes of a rocket's flights; the model in use stays as it is.

    Raises NoFlights for fewer than four clean flights with an apogee, DamagedModel.
    """
    history = flown(ledger, motors, rocket)
    used_in_fit = [flight.clean and flight.apogee is not None for flight, _ in history]
    if sum(used_in_fit) < MIN_FLIGHTS:
        raise NoFlights(
            f"{rocket}: found {sum(used_in_fit)} clean flights with an apogee, expected at least {MIN_FLIGHTS}"
        )
    return quick_look(rocket, history, used_in_fit)
