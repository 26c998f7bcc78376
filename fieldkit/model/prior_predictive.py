"""Simulated flights with known drag and thrust, for training and evaluating the field ensemble.

Every nuisance in the field is drawn at random, so that a posterior trained here allows for it: a wrong scale, a launch
rod off vertical, wind, unmeasured air, a motor that burns slower than its certificate, a charge that fires early, an
altimeter that reads a little high.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol, runtime_checkable

import numpy as np

from fieldkit.model.field_features import closed_form
from fieldkit.model.hyperprior import START
from fieldkit.model.observations import (
    ALPHA_RANGE,
    ALPHA_SD,
    CD_RANGE,
    DECLARED_FIELDS,
    FIGURES,
    READOUT_NAMES,
    diameter_range,
    disc,
    figures,
)
from fieldkit.model.random_effects import bent, shown_by
from fieldkit.motors import Motor, catalogue
from fieldkit.physics.atmosphere import GRAVITY, altimeter_gain, pad_air
from fieldkit.physics.flight import fly
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import burns
from fieldkit.shapes import Array, Float, Int

CLASSES = ("1/8A", "1/4A", "1/2A", "A", "B", "C", "D", "E", "F", "G", "H", "I")
"""Impulse classes of the motors flown; all classes in the catalog are equally likely."""
HELD_OUT = "Quest"
"""The manufacturer whose motors are held out of training and used for evaluation."""
MIN_MOTOR_DIAMETER = 0.008
"""Motors up to this diameter are left out. [m]"""
THRUST_TO_WEIGHT = (2.2, 30.0)
"""Bounds of mean thrust to lift-off weight; the dry mass is uniform in its logarithm between them. [1]"""
STEPS = 8
"""Minimum number of integration steps in a burn; the knots of most thrust curves require more."""
TAIL = START.tail
"""Degrees of freedom of heavy-tailed scatter: a few motors and readings are far off. [1]"""
DELAY_SPREAD = 0.3
"""Standard deviation of a delay in addition to its relative part: short delays scatter by more than a tenth. [s]"""
LONGEST_STRETCH = float(np.log(2.0))
"""Largest change of the log burn time: the motor named may be another one. [1]"""

PRIORS: Mapping[str, str] = MappingProxyType(
    {
        "motor": "class uniform among those up to I, motor uniform within its class",
        "cd": f"log-uniform {CD_RANGE[0]} to {CD_RANGE[1]} [1]",
        "alpha": f"normal, 1 and {ALPHA_SD}, between {ALPHA_RANGE[0]} and {ALPHA_RANGE[1]} [1]",
        "dry_mass": "log-uniform, so that mean thrust to weight is 2.2 to 30; at least 8 g and 0.35 of the motor [kg]",
        "diameter": (
            "log-uniform, from the motor + 1 mm (at least 13 mm) to the smallest of 100 mm, five motors and "
            "20 mm sqrt(mass / 7 g) [m]"
        ),
        "weighing": (
            "error normal, 1.5%; in 30% of flights also heavier by a half-normal 8%, in 30% by up to 12 g; casing "
            "normal, 5%"
        ),
        "burn_stretch": "log of a Student t, 6% with 4 degrees of freedom, at most by 2 [1]",
        "wind": "Rayleigh, mean 3.1 m/s; the rocket turns into it with a strength uniform 0 to 1 [m/s]",
        "rail_angle": "normal, 5 degrees, recorded to 1.5 degrees [rad]",
        "rail_length": "log-uniform 0.9 to 2.5 [m]",
        "site_elevation": "in 60% uniform to 300, in 30% to 1000, in 10% to 2200 [m]",
        "temperature": "normal, 20 and 9 degrees Celsius at sea level, 4.5 K lower per km; recorded to 1.5 K",
        "pressure": "normal, 1015 and 7 hPa at sea level; recorded to 1 hPa",
        "delay": "one on sale, in 85% near the coast time; error normal, 10% and 0.3 s; in 6% early by 20 to 70%",
        "descent_speed": "log-normal, 5.5 m/s and 45%",
        "altimeter_gain": "that of the air, and 1% of the device [1]",
    }
)
"""Every prior, in words; the noise of each readout is in `observation_noise`."""


@dataclass(frozen=True, slots=True)
class Truth:
    """The true simulated flights, one entry per flight: `readouts` without noise, every field declared. SI."""

    motor: Float[Array, "flight figure"]
    declared: Float[Array, "flight declared"]
    readouts: Float[Array, "flight readout"]
    drag_area: Float[Array, "flight"]
    alpha: Float[Array, "flight"]

    def __len__(self) -> int:
        return len(self.alpha)

    def rows(self, which: Any) -> "Truth":
        """The selected flights."""
        return Truth(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    @property
    def parameters(self) -> Float[Array, "flight 2"]:
        """Logarithm of the drag area [log m^2], and alpha [1]."""
        return np.stack([np.log(self.drag_area), self.alpha], axis=-1)

    @property
    def cd(self) -> Float[Array, "flight"]:
        """Drag coefficient on the true diameter. [1]"""
        return self.drag_area / disc(self.declared[:, DECLARED_FIELDS.index("diameter")])


def flown_motors(motors: Sequence[Motor]) -> list[Motor]:
    """Motors up to class I that can lift an altimeter, which 6 mm motors cannot."""
    return [motor for motor in motors if motor.impulse_class in CLASSES and motor.diameter > MIN_MOTOR_DIAMETER]


def split_motors() -> tuple[list[Motor], list[Motor]]:
    """The motors up to class I of all manufacturers but the held-out one, and the motors of that one."""
    flown = flown_motors(catalogue().motors)
    return [m for m in flown if m.maker != HELD_OUT], [m for m in flown if m.maker == HELD_OUT]


def simulate(rng: np.random.Generator, motors: Sequence[Motor], count: int, named: Sequence[str] = ()) -> Truth:
    """About the requested number of flights: flights that do not leave the pad, or barely do, are left out.

    Effects in `named` act on every flight, each with a strength drawn from its prior. Raises BadValue for an unknown
    effect.
    """
    row = _draw_motors(rng, motors, count)
    table = np.stack([figures(motor) for motor in motors])[row]
    declared = _draw_declared(rng, table)
    cd = _log_uniform(rng, *(np.full(count, end) for end in CD_RANGE))
    alpha = _draw_alpha(rng, count)
    drag_area = cd * disc(declared["diameter"])
    declared["delay"] = _draw_delays(rng, motors, row, table, declared["dry_mass"], drag_area, alpha)
    setup = flown_field(rng, table, declared, drag_area, alpha)
    setup, bends = bent(rng, named, setup, count)
    flown = fly(setup.with_changes(burns=burns(motors, steps=STEPS), motor=row))
    shown = shown_by(bends, flown.readouts())
    readouts = np.stack([shown[name] for name in READOUT_NAMES], axis=-1)
    lifted = (flown.lift_off > 0) & (readouts[:, 0] > 5.0) & (readouts[:, 1] > 3.0)
    known = np.stack([declared[name] for name in DECLARED_FIELDS], axis=-1)
    return Truth(table, known, readouts, drag_area, alpha).rows(lifted)


def _draw_motors(rng: np.random.Generator, motors: Sequence[Motor], count: int) -> Int[Any, "flight"]:
    names = np.array([motor.impulse_class for motor in motors])
    weights = 1.0 / np.array([(names == name).sum() for name in names])
    return rng.choice(len(motors), size=count, p=weights / weights.sum())


def _draw_declared(rng: np.random.Generator, table: Float[Array, "flight figure"]) -> dict[str, Array]:
    """A complete record of the flights, without mistakes."""
    count = len(table)
    impulse, burn_time, width = table[:, 0], table[:, 1], table[:, 8]
    loaded = table[:, 6] + table[:, 7]
    weight = impulse / burn_time / GRAVITY
    lightest = np.maximum(np.maximum(weight / THRUST_TO_WEIGHT[1] - loaded, 0.35 * loaded), 0.008)
    heaviest = np.maximum(weight / THRUST_TO_WEIGHT[0] - loaded, 1.2 * lightest)
    dry_mass = _log_uniform(rng, lightest, heaviest)
    elevation = rng.uniform(size=count) * rng.choice([300.0, 1000.0, 2200.0], size=count, p=[0.6, 0.3, 0.1])
    return {
        "dry_mass": dry_mass,
        "diameter": _log_uniform(rng, *diameter_range(width, dry_mass)),
        "delay": np.full(count, np.nan),
        "site_elevation": elevation,
        "temperature": rng.normal(293.15, 9.0, count) - 0.0045 * elevation,
        "pressure": rng.normal(101500.0, 700.0, count),
        "humidity": rng.uniform(0.2, 1.0, count),
        "wind": rng.rayleigh(2.5, count),
        "rail_length": _log_uniform(rng, np.full(count, 0.9), np.full(count, 2.5)),
        "rail_angle": rng.normal(0.0, np.radians(5.0), count),
    }


def _draw_alpha(rng: np.random.Generator, count: int) -> Float[Array, "flight"]:
    alpha = rng.normal(1.0, ALPHA_SD, count)
    while (beyond := (alpha <= ALPHA_RANGE[0]) | (alpha >= ALPHA_RANGE[1])).any():
        alpha[beyond] = rng.normal(1.0, ALPHA_SD, beyond.sum())
    return alpha


def _log_uniform(rng: np.random.Generator, low: Array, high: Array) -> Array:
    return np.asarray(np.exp(rng.uniform(np.log(low), np.log(high))))


def _draw_delays(
    rng: np.random.Generator,
    motors: Sequence[Motor],
    row: Int[Any, "flight"],
    table: Float[Array, "flight figure"],
    dry_mass: Array,
    drag_area: Array,
    alpha: Array,
) -> Float[Array, "flight"]:
    """A delay on sale, mostly near the expected coast time; nan if there is none. [s]"""
    longest = max(len(motor.delays) for motor in motors)
    sold = np.full((len(motors), longest), np.nan)
    for number, motor in enumerate(motors):
        sold[number, : len(motor.delays)] = [delay if np.isfinite(delay) else np.nan for delay in motor.delays]
    coast = closed_form(dict(zip(FIGURES, table.T, strict=True)), dry_mass, drag_area, alpha, np.asarray(1.2))[
        "coast_to_apogee"
    ]
    careless = rng.uniform(size=len(row)) < 0.15
    taste = np.where(careless[:, None], 0.0, -np.abs(sold[row] - coast[:, None])) + rng.gumbel(size=(len(row), longest))
    best = np.argmax(np.where(np.isnan(sold[row]), -np.inf, taste), axis=1)
    return np.asarray(sold[row, best])


@runtime_checkable
class Chance(Protocol):
    """The source of random numbers for a flight's conditions: a generator, or a replacement for one."""

    def normal(self, loc: Any = ..., scale: Any = ..., size: Any = ...) -> Any: ...
    def uniform(self, low: Any = ..., high: Any = ..., size: Any = ...) -> Any: ...
    def standard_t(self, df: Any, size: Any = ...) -> Any: ...


def flown_field(
    rng: Chance,
    table: Float[Array, "flight figure"],
    declared: dict[str, Array],
    area: Array,
    alpha: Array,
) -> Setup:
    """The true flights: what was recorded, with its errors, and everything that was not.

    One entry per flight: the figures of its motor (`FIGURES`), what was recorded (`DECLARED_FIELDS`), drag area [m^2]
    and thrust scale [1]; all in SI.
    """
    count = len(table)
    elevation = declared["site_elevation"]
    temperature = declared["temperature"] + rng.normal(0.0, 1.5, count)
    pressure = declared["pressure"] + rng.normal(0.0, 100.0, count)
    early = np.where(rng.uniform(size=count) < 0.06, rng.uniform(0.3, 0.8, count), 1.0)
    heavier = np.where(rng.uniform(size=count) < 0.3, 0.08 * np.abs(rng.normal(size=count)), 0.0)
    forgotten = np.where(rng.uniform(size=count) < 0.3, rng.uniform(0.0, 0.012, count), 0.0)
    weighed = declared["dry_mass"] * (1 + 0.015 * rng.normal(size=count) + heavier) + forgotten
    weighed = weighed + 0.05 * table[:, 7] * rng.normal(size=count)
    gain = altimeter_gain(elevation, temperature, pressure)
    return Setup(
        burns=burns([_STILL_CURVE]),
        air=pad_air(elevation, temperature, pressure, declared["humidity"]),
        dry_mass=np.maximum(weighed, 0.5 * declared["dry_mass"]),
        drag_area=area,
        thrust_factor=alpha,
        burn_stretch=np.exp(np.clip(0.06 * rng.standard_t(TAIL, size=count), -LONGEST_STRETCH, LONGEST_STRETCH)),
        rail_length=declared["rail_length"],
        rail_angle=declared["rail_angle"] + rng.normal(0.0, np.radians(1.5), count),
        recorded_wind=declared["wind"],
        wind=declared["wind"] * np.exp(0.2 * rng.normal(size=count)) * rng.uniform(size=count),
        delay=np.maximum(
            (declared["delay"] * (1 + 0.1 * rng.normal(size=count)) + DELAY_SPREAD * rng.normal(size=count)) * early,
            0.2,
        ),
        descent_speed=5.5 * np.exp(0.45 * rng.normal(size=count)),
        altimeter_gain=gain * (1 + 0.01 * rng.normal(size=count)),
    )


@dataclass(frozen=True, slots=True)
class _Still:
    """A placeholder until the motors are filled in."""

    time: Array
    thrust: Array
    burnout: float = 1.0
    propellant_mass: float = 1.0
    casing_mass: float = 0.0


_STILL_CURVE = _Still(np.array([0.0, 0.5, 1.0]), np.array([0.0, 1.0, 0.0]))
