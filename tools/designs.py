"""Print stored simulations of public OpenRocket designs beside the same flights here: python -m tools.designs

Of each simulation OpenRocket's figures are used: mass on the pad, diameter, rod, Cd, and the same wind at all heights.
It is flown with the curve that OpenRocket flies, and with that of the catalog, held to the certified record; where
the second is off by more than 5%, the last column says how the curves differ.
"""

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors import catalogue
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from tests.openrocket.test_simulations import EXAMPLES, _motor, simulated

DESIGNS = ("A simple model rocket", "ARC payload rocket", "Dual parachute deployment", "Chute release")
"""Designs of one stage with one motor."""
AGREES = 0.05
"""Difference of apogees above which the reason is printed. [1]"""


def with_catalog_curve(name: str, place: int) -> tuple[float, str]:
    """The apogee of a simulation on the motor of the catalog [m], and how its curve differs."""
    row = EXAMPLES[name][place]
    found = catalogue().resolve(row["motors"])
    plan = Flight(
        dry_mass=float(row["lift_off_kg"]) - found.motor.loaded_mass,
        diameter=float(row["diameter_mm"]) / 1e3,
        rail_length=float(row["rod_m"]),
        descent_speed=float(row["landing_mps"]),
        extra={"opening_time_s": "0"},
    )
    area = np.pi / 4 * (float(row["diameter_mm"]) / 1e3) ** 2
    setup = field_setup([plan], [found], np.array([float(row["cd_thrust"]) * area]))
    ratio = np.array([float(row["cd_coast"]) / float(row["cd_thrust"])])
    flown = fly(setup.with_changes(power_off_drag=ratio, wind=np.array([2.0]), wind_power=np.zeros(1)))
    theirs = _motor(name, place).motor
    curves = f"{theirs.total_impulse:.3g} N s there, {found.motor.total_impulse:.3g} N s certified"
    return float(flown.apogee[0]), "; ".join(filter(None, (curves, found.motor.curve)))


def main() -> None:
    """Print the table."""
    print("| design | motor | stored [m] | its curve [m] | off | catalog's curve [m] | off | why |")
    print("|---|---|---|---|---|---|---|---|")
    for name in DESIGNS:
        for place, row in enumerate(EXAMPLES[name]):
            stored, same = float(row["apogee_m"]), float(simulated(name, place).apogee[0])
            own, why = with_catalog_curve(name, place)
            cells = f"{stored:.0f} | {same:.0f} | {same / stored - 1:+.1%} | {own:.0f} | {own / stored - 1:+.1%}"
            print(f"| {name} | {row['motors']} | {cells} | {why if abs(own / stored - 1) > AGREES else ''} |")


if __name__ == "__main__":
    main()
