"""The flights of one rocket with their motors, collected once: columns as arrays, groups, and the setup to simulate."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.further import names_a_device, text_under
from fieldkit.flight.launch_conditions import LaunchConditions, launch_conditions
from fieldkit.flight.recovery import UNCERTAIN_WEATHER
from fieldkit.motors import Found
from fieldkit.motors.lots import lots, recorded_lot
from fieldkit.physics import setups
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import FORECAST_RESOLUTION, Resolution
from fieldkit.physics.wind import WindProfile
from fieldkit.shapes import Array, Float

T = TypeVar("T")
GROUP_LEVELS = ("motor", "config", "site", "day")
"""Properties that group flights."""


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """The flights of one rocket in the order flown, with their motors; after the first `flown` come plans.

    `flight_index` is the position of each flight in the order flown, from 0; alternative plans share one.
    `used_in_fit` marks the flown flights that a fit uses. `own_area` replaces the reference area of the flights. [m^2]
    """

    flights: tuple[Flight, ...]
    found: tuple[Found, ...]
    flown: int
    flight_index: tuple[int, ...]
    used_in_fit: tuple[bool, ...]
    conditions: tuple[LaunchConditions, ...]
    own_area: Float[Array, "flight"] | None = None
    uncertain: tuple[str, ...] = ()
    """Which of `UNCERTAIN_WEATHER` have a standard deviation on some flight, also of a part."""
    _known: dict[object, Any] = field(init=False, repr=False, compare=False, default_factory=dict)

    @property
    def area(self) -> Float[Array, "flight"]:
        """Reference area of each flight. [m^2] Raises ImpossibleFlight for a flight without a dry mass."""
        if self.own_area is not None:
            return self.own_area
        return self.once("area", lambda: setups.reference_area(self.flights, self.flown))

    @property
    def diameter_known(self) -> bool:
        """Whether the area follows from a recorded diameter."""
        return setups.diameter_known(self.flights, self.flown)

    @property
    def delays(self) -> Float[Array, "flight"]:
        """Time from burnout to the ejection charge; nan if not known. [s]"""
        return self.once("delays", lambda: setups.delays(self.flights, self.found))

    @property
    def past(self) -> "History":
        """The flown flights alone."""
        return self.part(slice(self.flown))

    def column(self, name: str) -> Float[Array, "flight"]:
        """One number of every flight in SI, nan if it was not recorded."""
        return self.once(name, lambda: setups.recorded(self.flights, name))

    def groups(self, per: str) -> list[str]:
        """The group each flight belongs to, as in `groups`."""
        return self.once(("group", per), lambda: groups(self.flights, self.found, per))

    @property
    def drag_switches(self) -> tuple[bool | None, ...]:
        """Whether the drag of each flight switches, as the flyer recorded it; None if not."""
        return self.once("drag switches", lambda: tuple(flight.columns.drag_switched for flight in self.flights))

    def weather_sd(self, name: str) -> Float[Array, "flight"]:
        """Recorded standard deviation of one of `UNCERTAIN_WEATHER`, 0 if there is none. [K, Pa, m/s]"""
        place = tuple(UNCERTAIN_WEATHER).index(name)
        return self.once(("sd", name), lambda: np.array([one.weather_sd[place] for one in self.conditions]))

    def setup(self, resolution: Resolution = FORECAST_RESOLUTION) -> Setup:
        """The flights as recorded, to be simulated with the drag of a coefficient of 1; errors as in
        `fieldkit.physics.setups.setup_of`. [SI]"""
        return self.once(
            ("setup", resolution),
            lambda: setups.setup_of(self.flights, self.found, self.conditions, self.area, 1.0, resolution),
        )

    def once(self, name: object, compute: Callable[[], T]) -> T:
        """The result of a computation that depends only on this history, saved under a name."""
        if name not in self._known:
            self._known[name] = compute()
        found: T = self._known[name]
        return found

    def using(self, used_in_fit: Sequence[bool]) -> "History":
        """The same with other flights used in the fit."""
        return replace(self, used_in_fit=tuple(map(bool, used_in_fit)))

    def with_delays(self, delays: Sequence[float | None]) -> "History":
        """The same with another delay of each flight's motor. [s]"""
        timed = zip(self.flights, delays, strict=True)
        return replace(self, flights=tuple(flight.with_changes(delay=delay) for flight, delay in timed))

    def part(self, rows: slice) -> "History":
        """Only some of the flights, each with the area it has among all."""
        past = range(len(self.flights))[rows]
        own = {name: getattr(self, name)[rows] for name in ("flights", "found", "flight_index", "conditions")}
        used = tuple(self.used_in_fit[row] for row in past if row < self.flown)
        return replace(self, **own, flown=len(used), used_in_fit=used, own_area=self.area[rows])


def history_of(
    flights: Sequence[Flight],
    found: Sequence[Found],
    flown: int | None = None,
    flight_index: Sequence[int] | None = None,
    used_in_fit: Sequence[bool] | None = None,
) -> History:
    """The history of a rocket whose first `flown` flights, by default all, have flown, and by default the clean ones
    are used in the fit. The flight index counts from 0 by default."""
    count = len(flights) if flown is None else flown
    used = [flight.clean for flight in flights[:count]] if used_in_fit is None else used_in_fit
    order = range(len(flights)) if flight_index is None else flight_index
    conditions = tuple(launch_conditions(flight) for flight in flights)
    uncertain = [
        name for place, name in enumerate(UNCERTAIN_WEATHER) if any(one.weather_sd[place] for one in conditions)
    ]
    every = tuple(flights), tuple(found), count, tuple(order), tuple(map(bool, used)), conditions
    return History(*every, uncertain=tuple(uncertain))


def flown_and_planned(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]] = (),
    flight_index: Sequence[int] | None = None,
) -> History:
    """The history of flown flights with their motors and of plans, each with its flight index, by default the next.
    Errors as in `history_of`."""
    both, count = [*flown, *planned], len(flown)
    order = [*range(count), *(flight_index or [count] * len(planned))]
    return history_of([flight for flight, _ in both], [found for _, found in both], count, order)


def together(histories: Sequence[History]) -> History:
    """The flights of several rockets as one history without past, to be simulated in one batch, each with its own
    area."""
    flights, found, conditions = (
        tuple(each for one in histories for each in getattr(one, name)) for name in ("flights", "found", "conditions")
    )
    area = np.concatenate([one.area for one in histories])
    return History(flights, found, 0, tuple(range(len(flights))), (), conditions, area)


def field_setup(
    flights: Sequence[Flight],
    found: Sequence[Found],
    drag_area: Float[Array, "*draw flight"],
    thrust_factor: Float[Array, "*draw flight"] | float = 1.0,
    resolution: Resolution = FORECAST_RESOLUTION,
) -> Setup:
    """Flights of any rockets as in `setup_of`, in SI. Raises ImpossibleFlight for a flight without a dry mass."""
    conditions = [launch_conditions(flight) for flight in flights]
    return setups.setup_of(flights, found, conditions, drag_area, thrust_factor, resolution)


def recorded_wind(flight: Flight) -> WindProfile:
    """Wind profile of a flight; calm if none was recorded."""
    return setups.wind_profile(flight.wind, launch_conditions(flight))


def groups(flights: Sequence[Flight], found: Sequence[Found], per: str) -> list[str]:
    """The group each flight belongs to: its motor type, the lot of its motor, its configuration, site, day or
    altimeter."""
    if per in ("motor", "lot"):
        motors = [f"{item.motor.maker} {item.motor.designation}" for item in found]
        return motors if per == "motor" else lots(motors, [recorded_lot(flight) for flight in flights])
    if per == "day":
        return [flight.date_time.date().isoformat() if flight.date_time else "" for flight in flights]
    if per == "device":
        return [text_under(flight, names_a_device) for flight in flights]
    return [str(getattr(flight, per)) for flight in flights]
