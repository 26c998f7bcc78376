"""The setup of a simulated flight, the state from which forces are computed, and the result."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from operator import attrgetter
from typing import Any

import numpy as np

from fieldkit.physics.atmosphere import WIND_EXPONENT, Air
from fieldkit.physics.thrust_steps import Burns
from fieldkit.shapes import Array, Flags, Float, Int, Integers


@dataclass(frozen=True, slots=True)
class State:
    """State at one time of the ascent, one entry per draw.

    `height` above the pad [m]; `speed` through the air [m/s]; `drag` deceleration by drag [m/s^2]; `burning` whether
    this is before burnout (one value for all draws: the integrator ends the burn of all draws together).
    """

    height: Float[Array, "*draw"]
    speed: Float[Array, "*draw"]
    drag: Float[Array, "*draw"]
    burning: bool
    air: Air


Force = Callable[[State, Float[Array, "*draw"]], Float[Array, "*draw"]]
"""Acceleration along the path that an effect adds at a given strength; negative values decelerate. [m/s^2]"""


def _for_all(value: float) -> Any:
    """A default with one value for all draws."""
    return field(default_factory=lambda: np.asarray(value))


@dataclass(frozen=True, slots=True)
class Setup:
    """All inputs of a simulated flight, one entry per draw (or one for all), in SI units.

    `motor` indexes a row of `burns`. `drag_area` is Cd times the reference area [m^2], `thrust_factor` multiplies
    thrust [1], `burn_stretch` lengthens the burn at the same impulse [1]. `wind` is the wind that turns the rocket,
    measured at the pad [m/s]; it increases with height to the power `wind_power` [1] up to `wind_top` [m]. `rail_angle`
    is from vertical, positive away from the wind; `rail_across` is perpendicular to it, positive to the right [rad].
    `turn_length` is the distance off the rail over which the rocket turns into the relative wind [m], `power_off_drag`
    the ratio of coast drag to burn drag [1]. `delay` is from burnout to ejection, nan for none [s]; `opening_time` from
    the charge to an open parachute (half a second is an assumption) [s]; `descent_speed` is the speed under it [m/s].
    `altimeter_gain` is the ratio of displayed to true height [1]. `forces` are the accelerations that effects add in
    flight. `recorded_wind` [m/s] and `temperature_recorded` are for effects; the simulator does not read them. `stride`
    multiplies the step length of a slanted path [1]. `closed_coast` is whether a vertical coast without forces is
    computed in closed form rather than in steps.
    """

    burns: Burns
    air: Air
    dry_mass: Float[Array, "*#draw"]
    drag_area: Float[Array, "*#draw"]
    motor: Int[Any, "*#draw"] = _for_all(0)
    thrust_factor: Float[Array, "*#draw"] = _for_all(1.0)
    burn_stretch: Float[Array, "*#draw"] = _for_all(1.0)
    rail_length: Float[Array, "*#draw"] = _for_all(1.0)
    rail_angle: Float[Array, "*#draw"] = _for_all(0.0)
    rail_across: Float[Array, "*#draw"] = _for_all(0.0)
    rail_friction: Float[Array, "*#draw"] = _for_all(0.0)
    wind: Float[Array, "*#draw"] = _for_all(0.0)
    wind_power: Float[Array, "*#draw"] = _for_all(WIND_EXPONENT)
    wind_top: Float[Array, "*#draw"] = _for_all(np.inf)
    turn_length: Float[Array, "*#draw"] = _for_all(4.0)
    power_off_drag: Float[Array, "*#draw"] = _for_all(1.0)
    delay: Float[Array, "*#draw"] = _for_all(np.nan)
    opening_time: Float[Array, "*#draw"] = _for_all(0.5)
    descent_speed: Float[Array, "*#draw"] = _for_all(5.0)
    altimeter_gain: Float[Array, "*#draw"] = _for_all(1.0)
    recorded_wind: Float[Array, "*#draw"] = _for_all(0.0)
    temperature_recorded: Flags = field(default_factory=lambda: np.zeros((), bool))
    forces: tuple[tuple[Force, Float[Array, "*#draw"]], ...] = ()
    gravity: float = 9.80665
    pad_holds: bool = True
    stride: float = 1.0
    closed_coast: bool = True

    @property
    def draw_shape(self) -> tuple[int, ...]:
        """Shape that all entries broadcast to."""
        arrays = [*_per_draw(self), self.air.density, self.air.temperature, *(strength for _, strength in self.forces)]
        shapes = {a.shape for a in arrays} - {()}
        return shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)

    def with_changes(self, **changes: Any) -> "Setup":
        """The same setup with some entries changed."""
        return replace(self, **changes)

    def after_burnout(self) -> "Setup":
        """The same setup with coast drag."""
        if np.all(self.power_off_drag == 1.0):
            return self
        drag = np.asarray(self.drag_area * self.power_off_drag)
        return replace(self, drag_area=drag, power_off_drag=np.ones(1))

    def flat(self, shape: tuple[int, ...]) -> "Setup":
        """Every entry on one axis of draws, in the order of `shape`; an entry shared by all draws remains [1]."""

        def spread(values: Any) -> Any:
            one = np.size(values) == 1
            return np.reshape(values, 1) if one else np.broadcast_to(values, shape).reshape(-1)

        return self._mapped(spread)

    def part(self, rows: Int[Integers, "row"]) -> "Setup":
        """Some rows of a flat setup; draws that share a motor share its entry."""
        part = self._mapped(lambda values: values if len(values) == 1 else values[rows])
        shared = (part.motor == part.motor[0]).all()
        return replace(part, motor=part.motor[:1]) if shared else part

    @property
    def draws(self) -> int:
        """Number of draws of a flat setup."""
        return int(self.draw_shape[0])

    def _mapped(self, change: Callable[[Any], Any]) -> "Setup":
        air = replace(self.air, density=change(self.air.density), temperature=change(self.air.temperature))
        forces = tuple((force, change(strength)) for force, strength in self.forces)
        arrays = {name: change(getattr(self, name)) for name in PER_DRAW}
        none: dict[str, Any] = {name: np.zeros(1, getattr(self, name).dtype) for name in RECORDED_ENTRIES}
        return replace(self, air=air, forces=forces, **arrays, **none)


RECORDED_ENTRIES = ("recorded_wind", "temperature_recorded")
"""The entries that only effects read, before the flight; a flat setup has none of them."""
PER_DRAW = tuple(
    f.name
    for f in fields(Setup)
    if f.name not in ("burns", "air", "forces", "gravity", "pad_holds", "stride", "closed_coast", *RECORDED_ENTRIES)
)
"""The entries with one value per draw that the simulator reads."""
_per_draw = attrgetter(*PER_DRAW)


@dataclass(frozen=True, slots=True)
class FlightResult:
    """Results of a simulated flight, one entry per draw, in SI units; heights above the pad.

    `apogee` and `eject_altitude` are true heights, `apogee_shown` and `eject_altitude_shown` the readings of a
    barometric altimeter. `top_speed` is that along the path, and `top_climb` its upward part, with the direction at
    burnout. `burn_time` is from lift-off to top speed, as the altimeter defines it; accelerations are net of gravity.
    `drift` is the downwind distance of the apogee, `across` its distance to the right of the wind, `drift_speed` and
    `across_speed` the horizontal speeds there. `rise_time` is from lift-off to apogee, `coast_time` from burnout,
    negative if the motor still burns at apogee; `cut_short` is by how much a charge before apogee shortens them. nan if
    undefined (no delay, no ejection).
    """

    apogee: Float[Array, "*draw"]
    apogee_shown: Float[Array, "*draw"]
    top_speed: Float[Array, "*draw"]
    top_climb: Float[Array, "*draw"]
    burn_time: Float[Array, "*draw"]
    peak_accel: Float[Array, "*draw"]
    avg_accel: Float[Array, "*draw"]
    coast_to_apogee: Float[Array, "*draw"]
    apogee_to_eject: Float[Array, "*draw"]
    eject_altitude: Float[Array, "*draw"]
    eject_altitude_shown: Float[Array, "*draw"]
    eject_speed: Float[Array, "*draw"]
    descent_speed: Float[Array, "*draw"]
    duration: Float[Array, "*draw"]
    rail_speed: Float[Array, "*draw"]
    lift_off: Float[Array, "*draw"]
    drift: Float[Array, "*draw"]
    across: Float[Array, "*draw"]
    drift_speed: Float[Array, "*draw"]
    across_speed: Float[Array, "*draw"]
    rise_time: Float[Array, "*draw"]
    coast_time: Float[Array, "*draw"]
    cut_short: Float[Array, "*draw"]

    def readouts(self) -> dict[str, Float[Array, "*draw"]]:
        """The ten readouts by name, with heights as the altimeter reads them. SI."""
        shown = {"apogee": self.apogee_shown, "eject_altitude": self.eject_altitude_shown}
        names = (
            "apogee top_speed burn_time peak_accel avg_accel coast_to_apogee apogee_to_eject "
            "eject_altitude descent_speed duration"
        )
        return {name: shown.get(name, getattr(self, name)) for name in names.split()}
