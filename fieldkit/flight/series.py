"""The channels of a log on a common clock."""

from dataclasses import dataclass

from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Channels of a log on a common clock, in SI; a channel that was not recorded is None, a lost sample is nan.

    `time` [s] is the log's own and never decreases; its zero is the logger's: launch detection or the first sample.
    Heights are above the pad unless the name says `msl`, and up is positive. Quantities that the logger computed
    (`speed` by any method, `inertial_*` from its accelerometer, `gps_*`) are separate from its barometer channels
    (`pressure`, `altitude`). `felt` is the specific force along the rocket's axis, 1 g at rest with the nose up;
    `acceleration` is the same net of gravity, 0 at rest.
    """

    time: Float[Array, "time"]
    altitude: Float[Array, "time"] | None = None
    """By the barometer, above the pad. [m]"""
    altitude_msl: Float[Array, "time"] | None = None
    """By the barometer, above sea level. [m]"""
    pressure: Float[Array, "time"] | None = None
    """Static pressure inside the airframe. [Pa]"""
    speed: Float[Array, "time"] | None = None
    """Vertical speed as computed by the logger. [m/s]"""
    acceleration: Float[Array, "time"] | None = None
    """Along the axis, net of gravity. [m/s^2]"""
    felt: Float[Array, "time"] | None = None
    """Specific force along the axis, as an accelerometer measures it. [m/s^2]"""
    felt_total: Float[Array, "time"] | None = None
    """Magnitude of the specific force over all axes. [m/s^2]"""
    inertial_altitude: Float[Array, "time"] | None = None
    """Integrated from acceleration by the logger, above the pad. [m]"""
    inertial_speed: Float[Array, "time"] | None = None
    """Integrated from acceleration by the logger. [m/s]"""
    gps_altitude_msl: Float[Array, "time"] | None = None
    """Above sea level. [m]"""
    gps_speed: Float[Array, "time"] | None = None
    """Vertical speed by GPS. [m/s]"""
    latitude: Float[Array, "time"] | None = None
    """North positive. [deg]"""
    longitude: Float[Array, "time"] | None = None
    """East positive. [deg]"""
    tilt: Float[Array, "time"] | None = None
    """Angle of the axis from vertical. [rad]"""
    temperature: Float[Array, "time"] | None = None
    """Sensor temperature. [K]"""
    voltage: Float[Array, "time"] | None = None
    """Battery voltage. [V]"""
    thrust: Float[Array, "time"] | None = None
    """In simulations. [N]"""
    drag: Float[Array, "time"] | None = None
    """In simulations. [N]"""
    mass: Float[Array, "time"] | None = None
    """In simulations. [kg]"""
