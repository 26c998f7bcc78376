"""`python -m bench.compare`: the two simulators on a dozen launches, fast minus RocketPy, and what the product leaves
out, by the fast one."""

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bench import barrowman, fast_truth, truth
from bench.altimeter import exact_readouts
from bench.motors import motors
from bench.world import Air, Airframe, Drag, Launch

ROCKETS = (("D12", 0.041, 0.60, 0.15), ("F39T", 0.0546, 0.90, 0.40), ("G64W", 0.066, 1.20, 0.90))
CONDITIONS = ((0.5, 0.02, 2.0, 9.0), (5.0, 0.0, 2.0, 9.0), (8.0, 0.0, 3.0, 5.0), (2.0, 0.17, 1.3, 9.0))
"""Wind [m/s], angle of the rail [rad], static margin [caliber], delay [s]."""


def launches() -> list[Launch]:
    """A dozen launches over three sizes of rocket, and a fast one through Mach 1."""
    found = []
    for motor, diameter, length, mass in ROCKETS:
        for wind, tilt, margin, delay in CONDITIONS:
            calm = _launch(motor, diameter, length, mass, margin)
            air = Air(wind=wind, elevation=200)
            found.append(replace(calm, air=air, tilt=tilt, heading=2.0, delay=delay))
    fast = _launch("H128W", 0.041, 1.1, 0.45, 2.0)
    found.append(replace(fast, air=Air(wind=4), drag=Drag(0.45, 1.2, 0.7), rail_length=1.8, delay=12))
    return found


def _launch(name: str, diameter: float, length: float, mass: float, margin: float) -> Launch:
    motor = motors()[name]
    frame = Airframe(diameter, length, 0.2, 3, 0.09, 0.05, diameter * 1.1, 0.04, 0.0)
    cg = barrowman.cg_for_margin(frame, mass, motor.total_mass, motor.length, margin)
    return Launch(replace(frame, dry_cg=cg), mass, motor, Drag(0.5), Air(), rail_length=1.2)


LEFT_OUT: dict[str, Callable[[Launch], Launch]] = {
    "air that rises at 1 m/s": lambda one: replace(one, air=replace(one.air, updraft=1.0)),
    "air that sinks at 1 m/s": lambda one: replace(one, air=replace(one.air, updraft=-1.0)),
    "Cd, stated at 50 m/s, that falls with the speed to the power 0.2": lambda one: replace(
        one, drag=replace(one.drag, reynolds=0.2)
    ),
    "wind that turns by 90 degrees to 300 m": lambda one: replace(one, air=replace(one.air, turn=np.pi / 2)),
    "wind that turns by 180 degrees to 300 m": lambda one: replace(one, air=replace(one.air, turn=np.pi)),
}
"""What a forecast leaves out, and a launch with it."""


def gains(change: Callable[[Launch], Launch]) -> list[float]:
    """How much higher each launch flies with a change, without an early charge. [%]"""
    late = [replace(one, delay=30.0) for one in launches()]
    apogees = [
        [exact_readouts(track, one.air)["apogee_m"] for one, track in zip(some, fast_truth.fly(some), strict=True)]
        for some in (late, [change(one) for one in late])
    ]
    return [100 * (after / before - 1) for before, after in zip(*apogees, strict=True)]


def main() -> None:
    """Print a row per launch, RocketPy's readout and the difference of the fast simulator, and a row for what is left
    out, with the lowest and highest gain of all launches but the fast one, and that one's."""
    out = sys.stdout.write
    out(f"{'motor':6} {'wind':>4} {'tilt':>5} | {'apogee m':>16} {'speed m/s':>16} {'coast s':>14}\n")
    every = launches()
    for launch, track in zip(every, fast_truth.fly(every), strict=True):
        fast = exact_readouts(track, launch.air)
        slow = exact_readouts(truth.fly(launch), launch.air)
        cells = [
            f"{slow[name]:8.2f} {fast[name] - slow[name]:+7.2f}"
            for name in ("apogee_m", "top_speed_mps", "coast_to_apogee_s")
        ]
        out(f"{launch.motor.name:6} {launch.air.wind:4.1f} {launch.tilt:5.2f} | {' '.join(cells)}\n")
    for name, change in LEFT_OUT.items():
        *slower, fastest = gains(change)
        out(f"{name}: {min(slower):+.1f} to {max(slower):+.1f}% of the apogee, {fastest:+.1f}% for the fast one\n")


if __name__ == "__main__":
    main()
