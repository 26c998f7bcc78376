"""The motors fieldkit knows: those of ThrustCurve.org, shipped with it, and the user's own files."""

import gzip
import json
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from fieldkit.errors import BadValue, FieldkitError, UnknownMotor
from fieldkit.motors import search
from fieldkit.motors.corrections import Correction
from fieldkit.motors.listing import Listing, Listings
from fieldkit.motors.motor import PLUGGED_DELAY, Motor, normalised
from fieldkit.motors.names import MAX_NAME, parse, tidy
from fieldkit.motors.own_corrections import FILE_NAME, OwnCorrection, corrected
from fieldkit.motors.search import Found
from fieldkit.motors.several import Booster, names_several, resolve_several
from fieldkit.safe_text import printable

DATA = Path(__file__).with_name("catalogue.json.gz")
"""The catalog that `tools/motors.py` generates from the data of ThrustCurve.org."""


@dataclass(frozen=True, slots=True)
class Catalogue:
    """Motors by name. `about` describes their origin, and how many were left out and why."""

    listings: Listings
    about: Mapping[str, Any]
    lots: Mapping[tuple[str, str, str], Motor] = field(default_factory=dict)
    """Motors of single lots, by maker, designation and lot."""
    _several: dict[tuple[str, tuple[Booster, ...]], Found] = field(default_factory=dict, repr=False, compare=False)
    """Cache of clusters and stages, so each is a single object."""
    _resolved: dict[tuple[str, str], Found] = field(default_factory=dict, repr=False, compare=False)
    """Cache of texts and makers: a table names the same few motors in every row."""

    def __len__(self) -> int:
        return sum(map(len, self.listings.values()))

    @property
    def motors(self) -> list[Motor]:
        """Every motor; each curve is built on first use."""
        return [listing.motor() for listings in self.listings.values() for listing in listings]

    def find(self, text: str, maker: str = "") -> Found:
        """The only motor that matches a text. Raises UnknownMotor, AmbiguousMotor as `fieldkit.motors.search.find`."""
        return search.find(self.listings, split_lot(text)[0], maker)

    def resolve(self, text: str, maker: str = "") -> Found:
        """The motor that a text most probably means. Raises UnknownMotor as `fieldkit.motors.search.resolve`."""
        key = text, maker
        if key not in self._resolved:
            plain, lot = split_lot(text)
            found = search.resolve(self.listings, plain, maker)
            self._resolved[key] = self._of_lot(found, plain, lot) if lot else found
        return self._resolved[key]

    def resolve_several(self, text: str, boosters: tuple[Booster, ...] = ()) -> Found:
        """The motor named by a text, or the cluster or stages it names combined into one motor; see
        `fieldkit.motors.several`. Raises UnknownMotor, and BadValue for motors that cannot be combined."""
        if not names_several(text):
            return self.resolve(text)
        key = tidy(text), boosters
        if key not in self._several:
            self._several[key] = resolve_several(text, self.resolve, boosters)
        return self._several[key]

    def _of_lot(self, found: Found, plain: str, lot: str) -> Found:
        """The motor of a lot if its data is known, else the motor type, with a note."""
        own = self.lots.get(_lot_key(found.motor, lot))
        if own is None:
            return replace(found, notes=(*found.notes, _no_figures(lot)))
        motor = search.as_printed(own, parse(plain))
        return replace(found, motor=motor, notes=(*found.notes, *(one.text() for one in own.corrections)))

    def complaint(self, text: str) -> str | None:
        """What is wrong with a motor's name, in one line; None if one or more motors match."""
        try:
            self.resolve(text)
        except UnknownMotor as error:
            return str(error)
        return None

    def doubt(self, text: str) -> str:
        """What looks mistyped in the delay of a known motor's name; empty if nothing does, or if no motor matches."""
        with suppress(UnknownMotor):
            return self.resolve(text).doubt
        return ""

    def complaint_of_several(self, text: str) -> str | None:
        """Like `complaint`, but also None for a cluster that can be simulated."""
        try:
            self.resolve_several(text)
        except (UnknownMotor, BadValue) as error:
            return str(error)
        return None

    def search(self, text: str) -> list[Motor]:
        """Every motor that a text could mean, best first, or the cluster it names; see `fieldkit.motors.search`."""
        if names_several(text):
            with suppress(UnknownMotor, BadValue):
                return [self.resolve_several(text).motor]
        plain, lot = split_lot(text)
        found = search.search(self.listings, plain)
        return [self.lots.get(_lot_key(one, lot), one) for one in found] if lot else found

    def knows(self, text: str) -> bool:
        """Whether a text names several motors, or `search` finds motors that it could mean, not only similar names."""
        return names_several(text) or bool(search.matches(self.listings, split_lot(text)[0]))

    def unknown_lot(self, text: str, found: Iterable[Motor]) -> str:
        """A note if a text names a lot that none of the motors found for it has data of, else empty."""
        lot = split_lot(text)[1]
        return _no_figures(lot) if lot and not any(_lot_key(one, lot) in self.lots for one in found) else ""

    def with_motors(self, motors: Iterable[Motor]) -> "Catalogue":
        """The same catalog with the user's own motors, which override others of the same name."""
        listings = dict(self.listings)
        for motor in motors:
            listings[motor.name] = (_own(motor), *listings.get(motor.name, ()))
        return Catalogue(MappingProxyType(listings), self.about, self.lots)

    def with_corrections(self, rows: Iterable[OwnCorrection]) -> tuple["Catalogue", list[FieldkitError]]:
        """The same catalog with the user's own corrections, and an error for each row that cannot be applied."""
        rows, errors = list(rows), list[FieldkitError]()
        types = self._corrected([row for row in rows if not row.lot], errors)
        listings = {
            name: tuple([_with_motor(one, types.pop(_lot_key(one, ""), None)) for one in group])
            for name, group in self.listings.items()
        }  # a user's own motor comes before a shipped one of the same designation, and is the one that is found
        made = Catalogue(MappingProxyType(listings), self.about)
        lots = made._corrected([row for row in rows if row.lot], errors)
        return Catalogue(made.listings, made.about, MappingProxyType(lots)), errors

    def _corrected(
        self, rows: Iterable[OwnCorrection], errors: list[FieldkitError]
    ) -> dict[tuple[str, str, str], Motor]:
        """The motors that rows correct, by maker, designation and lot; errors are added to a list."""
        found: dict[tuple[str, str, str], Motor] = {}
        for row in rows:
            try:
                motor = self.find(f"{row.maker} {row.designation}").motor
                key = _lot_key(motor, row.lot)
                found[key] = corrected(found.get(key, motor), row)
            except FieldkitError as error:
                errors.append(BadValue(f"{FILE_NAME}, row {row.number}: {error}"))
        return found


_LOT = re.compile(r"[\s,;(](?:lot|batch)(?:\s+no\.?)?[\s#:]+([\w./-]+)\)?\s*$", re.IGNORECASE)


def split_lot(text: str) -> tuple[str, str]:
    """Split a motor's name from its lot, empty if none is given: `F24-4W lot 0412`."""
    found = _LOT.search(text) if len(text) <= MAX_NAME else None
    return (text[: found.start()].rstrip(" \t,;("), found[1]) if found else (text, "")


def _lot_key(motor: Motor | Listing, lot: str) -> tuple[str, str, str]:
    """The key of a motor in `Catalogue.lots`."""
    return motor.maker, motor.designation, lot.casefold()


def _no_figures(lot: str) -> str:
    own = f"no figures for lot {printable(lot)} in your corrections"
    return (
        f"{own}: it has those of its type, from which lots differ by 2 to 3% either way; flights on it show its thrust"
    )


def _with_motor(listing: Listing, motor: Motor | None) -> Listing:
    """A listing with a corrected motor; unchanged without one."""
    return listing if motor is None else replace(listing, motor=lambda: motor, delays=motor.delays)


@cache
def catalogue() -> Catalogue:
    """The shipped catalog, read once; each curve is read when its motor is first used."""
    data = json.loads(gzip.decompress(DATA.read_bytes()))
    entries = [dict(zip(data["columns"], row, strict=True)) for row in data.pop("motors")]
    build = cache(lambda number: _motor(entries[number], data["source"]))
    listings: dict[str, list[Listing]] = {}
    for number, entry in enumerate(entries):
        listings.setdefault(entry["name"], []).append(_shipped(entry, partial(build, number)))
    return Catalogue(MappingProxyType(listings), MappingProxyType(data))


def _shipped(entry: Mapping[str, Any], motor: Callable[[], Motor]) -> Listing:
    return Listing(
        entry["maker"],
        entry["name"],
        entry["designation"],
        entry["diameter_mm"] / 1e3,
        _delays(entry),
        entry["available"],
        " ".join((entry["case"], entry["propellant"])),
        motor,
        former=next((was for field, was, *_ in entry["corrections"] if field == "designation"), ""),
        propellant=entry["propellant"],
    )


def _delays(entry: Mapping[str, Any]) -> tuple[float, ...]:
    return tuple([PLUGGED_DELAY if delay == "P" else float(delay) for delay in entry["delays"]])


def _own(motor: Motor) -> Listing:
    return Listing(
        motor.maker,
        motor.name,
        motor.designation,
        motor.diameter,
        motor.delays,
        motor.available,
        " ".join((motor.case, motor.propellant)),
        lambda: motor,
        own=True,
    )


def _motor(entry: Mapping[str, Any], source: str) -> Motor:
    time, thrust = np.array(entry["curve"].split(), dtype=float).reshape(-1, 2).T.copy()
    thrust = normalised(time, thrust, entry["total_impulse_ns"])
    time.setflags(write=False)
    thrust.setflags(write=False)
    return Motor(
        maker=entry["maker"],
        name=entry["name"],
        designation=entry["designation"],
        impulse_class=entry["class"],
        kind=entry["kind"],
        diameter=entry["diameter_mm"] / 1e3,
        length=entry["length_mm"] / 1e3,
        total_impulse=float(entry["total_impulse_ns"]),
        propellant_mass=entry["propellant_g"] / 1e3,
        casing_mass=entry["casing_g"] / 1e3,
        delays=_delays(entry),
        available=entry["available"],
        time=time,
        thrust=thrust,
        source=source,
        case=entry["case"],
        propellant=entry["propellant"],
        url=entry["url"],
        certified_average=entry["average_n"],
        certified_peak=entry["peak_n"],
        certified_burn=entry["burn_s"],
        curve=entry["curve_origin"],
        corrections=tuple([Correction(*one) for one in entry["corrections"]]),
        estimated=tuple(entry["estimated"]),
    )
