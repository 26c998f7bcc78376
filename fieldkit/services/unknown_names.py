"""Names of a plan or a new flight that the ledger does not know, and may be misspelled."""

from collections.abc import Collection, Iterator, Mapping, Sequence

from fieldkit.errors import nearest, unknown
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.services.names import same_name
from fieldkit.services.sites import sites


def unknown_names(
    ledger: Ledger,
    flight: Flight,
    given: Mapping[str, object],
    *,
    new: bool = False,
    former: Collection[str] = (),
) -> Iterator[str]:
    """What is not known of the `given` names of a flight, with the nearest known ones.

    A rocket and a site, and with `new` also a configuration, may be new: only one similar to a known name is reported.
    `former` are names that are being corrected, and are not suggested.
    """
    rockets, places = ledger.names("rocket"), [site.name for site in sites(ledger)]
    known_rocket = flight.rocket in rockets
    if given.get("rocket") and not known_rocket and not ledger.rocket(flight.rocket).configurations:
        yield from _unknown("rocket", flight.rocket, _without(rockets, former), new=True)
    if given.get("config") and known_rocket:
        configs = _without(sorted({one.config for one in ledger.flights(flight.rocket)} - {""}), former)
        yield from _unknown(f"configuration of {flight.rocket} called", flight.config, configs, new=new)
    if given.get("site") and same_name(flight.site, places) not in places:
        yield from _unknown("site", flight.site, _without(places, former), new=True)


def _without(known: Sequence[str], former: Collection[str]) -> list[str]:
    return [name for name in known if name not in former]


def _unknown(kind: str, typed: str, known: Sequence[str], *, new: bool) -> Iterator[str]:
    if known and typed not in known and (not new or nearest(typed, known)):
        yield unknown(kind, typed, known)
