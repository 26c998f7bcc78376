"""Launch sites: elevation from the flights, and size, ceiling, distances and rules as saved."""

from collections.abc import Callable
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME
from fieldkit.flight.limits import check
from fieldkit.flight.site import SITE_LENGTHS, Site
from fieldkit.flight.storable import check_name
from fieldkit.ledger import Ledger
from fieldkit.messages import amount, marked, message
from fieldkit.services.names import same_name

SITES = "sites"
"""Name under which the ledger saves them."""
MAX_LENGTH = 1e6
"""A size, ceiling or distance from here on is a typing error. [m]"""


def sites(ledger: Ledger) -> list[Site]:
    """Every site in a flight or saved, the most recent first."""
    saved = ledger.draft(SITES) or {}
    names = dict.fromkeys([*ledger.names("site"), *saved])
    flown = ledger.elevations()
    return [Site(name, **{"elevation": flown.get(name)} | saved.get(name, {})) for name in names if name]


def site_of(ledger: Ledger, name: str) -> Site:
    """The known properties of a site, found regardless of case; only the name of a new one."""
    saved = (ledger.draft(SITES) or {}).get(name, {})
    if not name or "elevation" in saved:
        return Site(name, **saved)
    found = {site.name: site for site in sites(ledger)}
    return found.get(same_name(name, found), Site(name))


def keep_site(ledger: Ledger, name: str, *, rules: str | None = None, **lengths: float | None) -> Site:
    """Save the given properties of a site, `SITE_LENGTHS` [m] and its rules, and leave the others unchanged. Raises
    BadValue for a name that no table can show, an elevation that no site has, or a length that is not above zero and
    below `MAX_LENGTH`.
    """
    check_name(name)
    changes: dict[str, Any] = {key: value for key, value in lengths.items() if value is not None}
    changes |= {} if rules is None else {"rules": rules}
    try:
        if "elevation" in changes:
            check(BY_NAME["site_elevation"], changes["elevation"])
    except BadValue as error:
        raise BadValue(message(f"{name}, elevation: {marked(error)}")) from error
    for key in SITE_LENGTHS[1:]:
        if key in changes and not 0 < changes[key] < MAX_LENGTH:
            found, expected = amount(changes[key], "m"), amount(0.0, "m", to=MAX_LENGTH)
            raise BadValue(message(f"{name}, {key}: found {found}, expected {expected}"))
    ledger.change_draft(SITES, lambda saved: saved | {name: saved.get(name, {}) | changes}, "site", name)
    return site_of(ledger, name)


def with_site(ledger: Ledger, site: Site, was: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """The change of the saved sites that replaces one completely; `was` is its previous name.

    The elevation of a site with flights comes from its flights unless it was saved.
    """
    is_flown = was in ledger.names("site")

    def replaced(saved: dict[str, Any]) -> dict[str, Any]:
        from_flights = {"elevation"} if is_flown and "elevation" not in saved.get(was, {}) else set()
        known = {key: getattr(site, key) for key in (*SITE_LENGTHS, "rules") if key not in from_flights}
        others = {name: one for name, one in saved.items() if name != was}
        return others | {site.name: {key: value for key, value in known.items() if value not in (None, "")}}

    return replaced
