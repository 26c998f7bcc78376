"""Masses of motors that are missing or wrong in the catalog's source, estimated from similar motors."""

import math
from collections import defaultdict
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

from fieldkit.motors import catalogue

FASTEST_EXHAUST = 2700.0
"""Above this exhaust speed, a mass cannot be everything that leaves the motor: it lacks the nitrous of a hybrid.
[m/s]"""

Row = dict[str, Any]
"""A motor of the catalog, by column."""


def _exhaust(entry: Row) -> float:
    return float(entry["total_impulse_ns"] / entry["propellant_g"] * 1e3)


def estimate_propellant(rows: list[Row]) -> None:
    """Estimates a propellant mass that is missing, or more than twice what the maker's propellant needs.

    It uses the median exhaust speed of three or more motors of that maker with that propellant. Hybrids do not change.
    """
    peers = defaultdict(list)
    for entry in rows:
        if entry["propellant_g"] and entry["propellant"]:
            peers[entry["maker"], entry["propellant"]].append(_exhaust(entry))
    for entry in rows:
        similar = peers[entry["maker"], entry["propellant"]]
        if entry["kind"] == "hybrid" or len(similar) < 3:
            continue
        if not entry["propellant_g"] or _exhaust(entry) < median(similar) / 2:
            entry["propellant_g"] = round(entry["total_impulse_ns"] / median(similar) * 1e3, 2)
            entry["casing_g"] = round(entry["total_g"] - entry["propellant_g"], 4) if entry["total_g"] else None
            entry["estimated"].append("propellant mass")


def estimate_casing(rows: list[Row]) -> None:
    """Estimates the casing mass if the loaded mass is missing; hybrids do not change.

    It is the median of the maker's motors in the same case (leave-one-out error 3% in the median), or else a power law
    of diameter and length fitted to motors of the same kind (10 to 12%).
    """
    known = [entry for entry in rows if entry["casing_g"] and entry["kind"] != "hybrid"]
    laws = {kind: _power_law([entry for entry in known if entry["kind"] == kind]) for kind in ("SU", "reload")}
    for entry in rows:
        if entry["casing_g"] or entry["kind"] == "hybrid":
            continue
        same = [
            k["casing_g"] for k in known if entry["case"] and (k["maker"], k["case"]) == (entry["maker"], entry["case"])
        ]
        constant, diameter, length = laws[entry["kind"]]
        law = constant + diameter * math.log(entry["diameter_mm"]) + length * math.log(entry["length_mm"])
        entry["casing_g"] = round(median(same) if same else math.exp(law), 1)
        entry["estimated"].append("casing mass")


def _power_law(rows: list[Row]) -> tuple[float, float, float]:
    sizes = np.array([[1.0, math.log(entry["diameter_mm"]), math.log(entry["length_mm"])] for entry in rows])
    constant, diameter, length = np.linalg.lstsq(sizes, np.log([entry["casing_g"] for entry in rows]), rcond=None)[0]
    return float(constant), float(diameter), float(length)


def unfit(entry: Row) -> str:
    """Why the masses of a motor are unusable; empty if they are usable."""
    if not entry["propellant_g"] or not entry["casing_g"]:
        return "masses not on record"
    if entry["kind"] == "hybrid" and _exhaust(entry) > FASTEST_EXHAUST:
        return "nitrous not in the propellant mass"
    return "propellant heavier than the motor" if entry["casing_g"] <= 0 else ""


def _errors(field: str, estimate: Callable[[list[Row]], None], rows: list[Row]) -> list[float]:
    """Relative errors of the estimates of a mass that is listed, each estimated from the other motors. [1]"""
    errors = []
    for place, entry in enumerate(rows):
        hidden = {**entry, field: None, "estimated": []}
        estimate([*rows[:place], hidden, *rows[place + 1 :]])
        if hidden[field]:
            errors.append(abs(hidden[field] / entry[field] - 1))
    return errors


def main() -> None:
    """Print how far the estimates of listed masses are off."""
    rows = [
        {
            "maker": motor.maker,
            "case": motor.case,
            "kind": motor.kind,
            "propellant": motor.propellant,
            "diameter_mm": motor.diameter * 1e3,
            "length_mm": motor.length * 1e3,
            "total_impulse_ns": motor.total_impulse,
            "total_g": motor.loaded_mass * 1e3,
            "propellant_g": motor.propellant_mass * 1e3,
            "casing_g": motor.casing_mass * 1e3,
            "estimated": list(motor.estimated),
        }
        for motor in catalogue().motors
        if not motor.estimated
    ]
    for field, estimate in (("propellant_g", estimate_propellant), ("casing_g", estimate_casing)):
        found = _errors(field, estimate, rows)
        half, most = np.percentile(found, [50, 90])
        off = f"off by {half:.1%} in the median, nine in ten by less than {most:.1%}"
        print(f"{field}: {len(found)} estimated from other motors, {off}")


if __name__ == "__main__":
    main()
