"""What the flight being typed says, in a line."""

from fieldkit.flight import BY_NAME
from fieldkit.quantities import measure, number
from fieldkit.services.typed_flight import Interval, TypedEstimate

APOGEE = BY_NAME["apogee"]


def estimate_line(found: TypedEstimate, system: str) -> str:
    """Cd, alpha and the next apogee with their 90 % intervals, or what is missing for them."""
    if found.needs:
        return f"Cd and next apogee: needs {_listed(found.needs)}"
    if found.cd is None or found.alpha is None or found.next_apogee is None:
        return f"Cd and next apogee: {found.odd}"
    low, middle, high = found.next_apogee
    apogee = f"{measure(APOGEE, middle, system)} ({number(APOGEE, low, system)} to {number(APOGEE, high, system)})"
    return f"Cd {_ratio(found.cd)}  alpha {_ratio(found.alpha)}  next apogee {apogee}"


def _ratio(interval: Interval) -> str:
    low, middle, high = interval
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


def _listed(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
