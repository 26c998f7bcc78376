"""The channels of a log on one clock."""

from dataclasses import dataclass

from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Channels of a log on one clock, in SI; a channel that was not recorded is None, a lost sample nan.

    `time` [s] is the log's own, never runs backwards, and has its zero where the logger put it: at its launch
    detection, or at its first sample. Heights are above the pad unless the name says `msl`, up is positive, and
    what a logger worked out by itself (`speed` by whatever means, `inertial_*` from its accelerometer, `gps_*`)
    is separate from what its barometer says (`pressure`, `altitude`). `felt` is the specific force along the
    rocket's axis, one g at rest with the nose up; `acceleration` the same net of gravity, zero at rest.
    """

    time: Float[Array, "time"]
    altitude: Float[Array, "time"] | None = None
    """By the barometer, above the pad. [m]"""
    altitude_msl: Float[Array, "time"] | None = None
    """By the barometer, above sea level. [m]"""
    pressure: Float[Array, "time"] | None = None
    """Static, inside the airframe. [Pa]"""
    speed: Float[Array, "time"] | None = None
    """Vertical, as the logger gives it. [m/s]"""
    acceleration: Float[Array, "time"] | None = None
    """Along the axis, net of gravity. [m/s^2]"""
    felt: Float[Array, "time"] | None = None
    """Along the axis, as an accelerometer feels it. [m/s^2]"""
    felt_total: Float[Array, "time"] | None = None
    """Magnitude over all axes, as accelerometers feel it. [m/s^2]"""
    inertial_altitude: Float[Array, "time"] | None = None
    """Integrated from acceleration by the logger, above the pad. [m]"""
    inertial_speed: Float[Array, "time"] | None = None
    """Integrated from acceleration by the logger. [m/s]"""
    gps_altitude_msl: Float[Array, "time"] | None = None
    """Above sea level. [m]"""
    gps_speed: Float[Array, "time"] | None = None
    """Vertical, by satellite. [m/s]"""
    latitude: Float[Array, "time"] | None = None
    """North positive. [deg]"""
    longitude: Float[Array, "time"] | None = None
    """East positive. [deg]"""
    tilt: Float[Array, "time"] | None = None
    """Of the axis from the vertical. [rad]"""
    temperature: Float[Array, "time"] | None = None
    """Of the sensor. [K]"""
    voltage: Float[Array, "time"] | None = None
    """Of the battery. [V]"""
    thrust: Float[Array, "time"] | None = None
    """In simulations. [N]"""
    drag: Float[Array, "time"] | None = None
    """In simulations. [N]"""
    mass: Float[Array, "time"] | None = None
    """In simulations. [kg]"""
