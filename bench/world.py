"""Common types of the two simulators: the true rocket, the launch, and the track.

Nothing here comes from the product's simulator. SI throughout. Stations are measured from the tip of
the nose toward the tail; x points downwind, z up.
"""

from dataclasses import dataclass

from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Airframe:
    """The shape of a rocket: an ogive nose, a tube and one set of trapezoidal fins at the tail."""

    diameter: float
    """Diameter of the body. [m]"""
    length: float
    """Length from tip to tail. [m]"""
    nose: float
    """Length of the nose. [m]"""
    fins: int
    root: float
    """Chord of a fin at the body. [m]"""
    tip: float
    """Chord of a fin at its tip. [m]"""
    span: float
    """Distance from the body to the tip of a fin. [m]"""
    sweep: float
    """Distance of the tip's leading edge behind the root's. [m]"""
    dry_cg: float
    """Center of mass without the motor. [m]"""


@dataclass(frozen=True, slots=True)
class Motor:
    """A motor as it burns on one flight; `thrust` over `time` starts at ignition and ends at burnout."""

    name: str
    maker: str
    suffix: str
    diameter: float
    length: float
    total_mass: float
    propellant_mass: float
    delays: tuple[int, ...]
    time: Float[Array, "sample"]
    thrust: Float[Array, "sample"]

    @property
    def burn_time(self) -> float:
        """Time from ignition to burnout. [s]"""
        return float(self.time[-1])

    def printed(self, delay: float) -> str:
        """The motor's name with a delay, as flyers write it: `F24-7W`, `Estes D12-5`."""
        return f"{self.maker} {self.name}-{delay:g}{self.suffix}".strip()


@dataclass(frozen=True, slots=True)
class Drag:
    """The coefficient of axial drag: a constant and its variations."""

    cd: float
    """Drag coefficient under power, at low Mach number. [1]"""
    power_off: float = 1.0
    """Factor on `cd` after burnout. [1]"""
    mach_rise: float = 0.0
    """Maximum relative rise, just above Mach 1. [1]"""
    reynolds: float = 0.0
    """Exponent e of (speed / 50 m/s)^-e. [1]"""
    step: float = 1.0
    """Factor on the drag while it is switched. [1]"""
    step_from: float = 0.0
    step_to: float = 0.0
    """When drag is switched, from ignition. [s]"""


@dataclass(frozen=True, slots=True)
class Air:
    """The air over a pad. Wind blows toward +x and grows with height as a power of it."""

    elevation: float = 0.0
    """Elevation of the pad above sea level. [m]"""
    temperature: float = 288.15
    """Temperature at the pad. [K]"""
    qnh: float = 101325.0
    """Pressure reduced to sea level. [Pa]"""
    wind: float = 0.0
    """Wind speed at `wind_height` above the pad. [m/s]"""
    wind_height: float = 5.0
    shear: float = 0.14
    """Exponent of the wind profile: 1/7 over open ground. [1]"""
    updraft: float = 0.0
    """Upward speed of the whole air mass. [m/s]"""
    turn: float = 0.0
    """Angle by which the wind has turned at 300 m and above, in proportion to height below. [rad]"""


@dataclass(frozen=True, slots=True)
class Launch:
    """Everything that determines one flight, with the true values and not the recorded ones."""

    airframe: Airframe
    dry_mass: float
    """Mass with recovery and payload, without the motor. [kg]"""
    motor: Motor
    drag: Drag
    air: Air
    rail_length: float
    """Length of rail that guides the rocket. [m]"""
    tilt: float = 0.0
    """Angle of the rail from the vertical. [rad]"""
    heading: float = 0.0
    """Direction of the launch angle, from downwind: pi is into the wind. [rad]"""
    friction: float = 0.0
    """Force that holds the rocket back while it is on the rail. [N]"""
    delay: float = 6.0
    """Time from burnout to the ejection charge. [s]"""
    chute_area: float = 0.3
    """Drag area of the open parachute. [m^2]"""
    opening: float = 0.4
    """Time from the ejection charge to the open parachute. [s]"""

    @property
    def beyond_rocketpy(self) -> bool:
        """Whether it has something that is not supported with RocketPy: rail friction, an updraft, Reynolds-number
        effects on drag, drag that switches."""
        return bool(self.friction or self.air.updraft or self.drag.reynolds or self.drag.step != 1)


@dataclass(frozen=True, slots=True)
class Track:
    """The track of one flight, from ignition to landing."""

    time: Float[Array, "step"]
    height: Float[Array, "step"]
    """Height above the pad. [m]"""
    speed: Float[Array, "step"]
    """Speed over the ground in any direction. [m/s]"""
    push: Float[Array, "step"]
    """Specific force along the body, as measured by an accelerometer on the axis. [m/s^2]"""
    liftoff: float
    burnout: float
    ejection: float | None
    """When the charge fired; None if the rocket was down before. [s]"""
