"""Worlds that the seasons of the bench are flown in: how far motors, rockets and devices are from their documents, and
how single flights and readings scatter.

Without a world a season is nearly as documented (`bench.fleet`, `bench.altimeter`). A world takes its standard
deviations from a hyperprior, one learned from real flights or one stated before any was seen, but not its form: the
scatter of a flight is physical (thrust, drag, and a climb off the vertical, which only lowers the apogee), and flyers
differ evenly in the logarithm between 3 and 15%, not by a bell curve. Single flights have the tails of a Student t.
"""

from dataclasses import replace

import numpy as np

from bench.air import GRAVITY
from bench.altimeter import Altimeter
from bench.fleet import Flown, Scatter, Season
from fieldkit.model.hyperprior import READOUTS, START, Hyperprior, learned

FLYERS = (0.03, 0.15)
"""Standard deviations of log apogee between which flyers differ. [1]"""
GIVEN = 0.9
"""Probability that a flight records a readout besides the apogee: 86 to 95% in 63 flights of a journal. [1]"""
COLUMNS = {
    "top_speed_mps": "top_speed",
    "burn_time_s": "burn_time",
    "peak_accel_g": "peak_accel",
    "coast_to_apogee_s": "coast_to_apogee",
    "apogee_to_eject_s": "apogee_to_eject",
}


def hyperprior_of(world: str) -> Hyperprior:
    """The hyperprior with the standard deviations of a world: `start` or `learned`."""
    return {"start": START, "learned": learned()}[world]


def in_world(rng: np.random.Generator, season: Season, world: str) -> tuple[Season, dict[str, dict[str, float]]]:
    """A season as it is in a world, and what is true of it: by effect, the deviation of each motor or configuration."""
    own = hyperprior_of(world)
    motors, configs = (sorted({getattr(flown, kind) for flown in season.flights}) for kind in ("motor", "config"))
    rocket = own.sd("mass", "rocket") * rng.standard_normal()
    mass = dict.fromkeys(configs, float(own.mean("mass") + rocket))
    thrust, stretch, delay = (
        {one: float(own.sd(quantity, "motor") * rng.standard_normal()) for one in motors}
        for quantity in ("thrust", "stretch", "delay")
    )
    spread = float(np.exp(rng.uniform(*np.log(FLYERS))))

    def changed(flown: Flown) -> Flown:
        launch, motor = flown.launch, flown.launch.motor
        longer = float(np.exp(stretch[flown.motor]))
        curve = replace(
            motor, time=motor.time * longer, thrust=motor.thrust * float(np.exp(thrust[flown.motor])) / longer
        )
        heavier = launch.dry_mass * float(np.exp(mass[flown.config]))
        late = launch.delay * float(np.exp(delay[flown.motor]))
        return replace(
            flown,
            launch=replace(launch, motor=curve, dry_mass=heavier, delay=late),
            scatter=_scatter(rng, own, spread),
        )

    truth = {"motor_thrust": thrust, "thrust_curve": stretch, "mass_offset": mass}
    altimeter = _altimeter(rng, own)
    return replace(season, flights=tuple(changed(one) for one in season.flights), altimeter=altimeter), truth


def _scatter(rng: np.random.Generator, own: Hyperprior, spread: float) -> Scatter:
    """The scatter of one flight of a flyer whose apogees scatter by `spread`.

    Derivation: log apogee changes by 1.6 times the log thrust and -0.25 times the log drag, and a climb at a small
    angle a from the vertical loses a^2 of it (medians over 12 rockets of `null`, flown by `fast_truth`). Thrust at a
    third of the spread, drag at the spread, and an angle whose loss has 0.7 of it then have 0.28, 0.06 and 0.49 of its
    square; gusts, the scale and the device have the rest.
    """
    thrust, stretch, drag, delay = rng.standard_t(own.tail, 4)
    angle = float(np.sqrt(0.7 * spread / np.sqrt(2))) * float(rng.standard_normal())
    way = float(rng.uniform(0, 2 * np.pi))
    return Scatter(
        thrust=float(np.exp(np.clip(thrust * spread / 3, -0.5, 0.3))),
        stretch=float(np.exp(np.clip(own.sd("stretch", "flight") * stretch, -0.3, 0.3))),
        drag=float(np.exp(np.clip(drag * spread, -0.7, 1.0))),
        mass=0.001 * float(rng.standard_normal()),
        delay=float(np.exp(np.clip(own.sd("delay", "flight") * delay, -0.5, 0.5))),
        wind=max(0.0, 1 + 0.15 * float(rng.standard_normal())),
        launch_angle=(angle * float(np.cos(way)), angle * float(np.sin(way))),
    )


def _altimeter(rng: np.random.Generator, own: Hyperprior) -> Altimeter:
    """A device whose readouts are biased and scatter as those of real flights."""
    places = {column: READOUTS.index(name) for column, name in COLUMNS.items()}
    bias = {
        column: float(np.hypot(own.sd(name, "fleet"), own.sd(name, "rocket")) * rng.standard_normal())
        for column, name in COLUMNS.items()
    }
    units = {"peak_accel_g": GRAVITY}
    sds = {column: (own.fixed[place] / units.get(column, 1.0), own.ratio[place]) for column, place in places.items()}
    return Altimeter(bias=bias, sds=sds, given=GIVEN)
