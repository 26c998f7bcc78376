"""The estimate from the flight being entered, in one line."""

from fieldkit.flight import BY_NAME
from fieldkit.planning.quantiles import Three
from fieldkit.quantities import in_system, number, spelled, unit_of
from fieldkit.services.typed_flight import TypedEstimate

APOGEE = BY_NAME["apogee"]


def estimate_line(found: TypedEstimate, system: str) -> str:
    """Cd, alpha and apogee of the next flight with 90% intervals, marked as provisional, or the missing inputs."""
    if found.needs:
        return f"Next Cd and apogee: needs {_listed(found.needs)}"
    if found.cd is None or found.alpha is None or found.next_apogee is None:
        return f"Next Cd and apogee: {in_system(found.implausible_because, system)}"
    low, middle, high = (_whole(height, system) for height in found.next_apogee)
    apogee = f"≈{middle} {spelled(unit_of(APOGEE, system))} ({low}-{high})"
    return f"next Cd {_ratio(found.cd)}  thrust {_ratio(found.alpha)}  apogee {apogee}"


def estimate_rows(found: TypedEstimate, system: str) -> list[tuple[str, str, Three]]:
    """The same in rows: the name of a figure, its value with its 90% interval, and the interval; none if something is
    missing for them."""
    if found.cd is None or found.alpha is None or found.next_apogee is None:
        return []
    low, middle, high = (_whole(height, system) for height in found.next_apogee)
    apogee = f"≈{middle} {spelled(unit_of(APOGEE, system))} ({low}-{high})"
    return [
        ("next Cd", _ratio(found.cd), found.cd),
        ("thrust", _ratio(found.alpha), found.alpha),
        ("next apogee", apogee, found.next_apogee),
    ]


def _whole(height: float, system: str) -> str:
    """A height [m] without decimals, which are not significant in a preliminary estimate."""
    return f"{float(number(APOGEE, height, system)):.0f}"


def _ratio(interval: Three) -> str:
    low, middle, high = interval
    return f"≈{middle:.2f} ({low:.2f}-{high:.2f})"


def _listed(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
