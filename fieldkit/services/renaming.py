"""Changes of flights, and what follows for flights that move to another rocket, because it is renamed or merged."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain, count
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.ledger import Ledger, Version
from fieldkit.safe_text import whole_number
from fieldkit.selection.candidates import Place
from fieldkit.services.model_versions import version_average


@dataclass(frozen=True, slots=True)
class Renaming:
    """The changes of each flight, the correction of the loop that each rocket takes over, and notes for the flyer."""

    changes: list[dict[str, object]]
    corrections: dict[str, Version]
    notes: list[str]


def renaming(ledger: Ledger, flights: Sequence[Flight], changes: Sequence[Mapping[str, object]]) -> Renaming:
    """Changes of flights, with the next free number for each flight whose id its new rocket already has.

    The correction of a rocket of which no flight is left goes with its flights, unless the other rocket has one.
    """
    found = Renaming([dict(own) for own in changes], {}, [])
    for rocket in dict.fromkeys(str(own["rocket"]) for own in found.changes if "rocket" in own):
        moving = [
            (flight, own)
            for flight, own in zip(flights, found.changes, strict=True)
            if own.get("rocket") == rocket != flight.rocket
        ]
        here = {flight.flight_id for flight in ledger.flights(rocket)}
        taken = here | {flight.flight_id for flight, _ in moving}
        numbers = count(1 + max((number for id in taken if (number := whole_number(id)) is not None), default=0))
        for flight, own in moving:
            if "flight_id" not in own and flight.flight_id in here:
                own["flight_id"] = str(next(numbers))
                found.notes.append(f"{flight_label(flight.flight_id)} of {flight.rocket} is now {own['flight_id']}")
        for old in dict.fromkeys(flight.rocket for flight, _ in moving):
            ids = {one.flight_id: str(own.get("flight_id", one.flight_id)) for one, own in moving if one.rocket == old}
            version = ledger.active_version(old)
            if version is None or len(ids) < len(ledger.flights(old)):
                continue
            if rocket in found.corrections or ledger.active_version(rocket):
                found.notes.append(f"the correction of {old} is not used: {rocket} has its own")
                continue
            found.corrections[rocket] = replace(version, payload=_with_ids(version.payload, ids))
            if here:
                found.notes.append(
                    f"the correction of {old} is now used for every flight of {rocket}; the loop checks it"
                )
    return found


@dataclass(frozen=True, slots=True)
class Edited:
    """How many flights a change has changed, all of them after it, and notes for the flyer."""

    count: int
    flights: list[Flight]
    notes: list[str]


def edit_flights(ledger: Ledger, flights: Sequence[Flight], changes: Sequence[Mapping[str, object]]) -> Edited:
    """Change each flight as one change of the ledger, with what follows from a renamed rocket; see `renaming`.

    Raises LedgerError if another flight has a new name, BadValue.
    """
    found = renaming(ledger, flights, changes)
    after = [flight.with_changes(**own) for flight, own in zip(flights, found.changes, strict=True)]
    own = dict(zip(ledger.ids(flights), found.changes, strict=True))
    what = f"({', '.join(dict.fromkeys(chain(*found.changes)))})"
    return Edited(ledger.edit_each(own, "edit", what, found.corrections), after, found.notes)


def _with_ids(payload: Mapping[str, Any], ids: Mapping[str, str]) -> Mapping[str, Any]:
    """A saved correction whose effects start at, and act on, the same flights under their new ids."""
    if all(old == new for old, new in ids.items()):
        return payload
    try:
        average = version_average(payload)
    except BadValue:
        return payload  # forecasts report it
    sets = [
        {"probability": chance, "places": [asdict(_with_ids_of(place, ids)) for place in places]}
        for chance, places in average
    ]
    return {**payload, "averaged": sets}


def _with_ids_of(place: Place, ids: Mapping[str, str]) -> Place:
    pattern, switched = place.pattern, place.switched
    if pattern and pattern.kind in ("lasting", "repeated"):
        pattern = replace(pattern, of=ids.get(pattern.of, pattern.of))
    if switched:
        switched = replace(switched, amounts=tuple((ids.get(id, id), amount) for id, amount in switched.amounts))
    return replace(place, since=ids.get(place.since, place.since), pattern=pattern, switched=switched)
