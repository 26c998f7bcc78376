"""Flights that move to another rocket, because it is renamed or merged with another one."""

from collections.abc import Mapping, Sequence
from itertools import count

from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.ledger import Ledger
from fieldkit.safe_text import whole_number


def with_free_ids(
    ledger: Ledger, flights: Sequence[Flight], changes: Sequence[Mapping[str, object]]
) -> tuple[list[dict[str, object]], list[str]]:
    """The changes of flights, with the next free number for each flight whose id its new rocket already has, and notes
    on these, and on each correction of the loop that stays with a rocket without flights."""
    changed, notes = [dict(one) for one in changes], []
    for rocket in dict.fromkeys(str(one["rocket"]) for one in changed if "rocket" in one):
        moving = [
            (flight, one)
            for flight, one in zip(flights, changed, strict=True)
            if one.get("rocket") == rocket != flight.rocket and "flight_id" not in one
        ]
        here = {one.flight_id for one in ledger.flights(rocket)}
        taken = here | {flight.flight_id for flight, _ in moving}
        numbers = count(1 + max((number for one in taken if (number := whole_number(one)) is not None), default=0))
        for flight, one in moving:
            if flight.flight_id in here:
                one["flight_id"] = str(next(numbers))
                notes.append(f"{flight_label(flight.flight_id)} of {flight.rocket} is now {one['flight_id']}")
        for old in dict.fromkeys(flight.rocket for flight, _ in moving):
            left = len(ledger.flights(old)) - sum(flight.rocket == old for flight, _ in moving)
            if not left and ledger.active_version(old):
                notes.append(f"the correction of {old} is not used for {rocket}; `fieldkit loop` finds it again")
    return changed, notes
