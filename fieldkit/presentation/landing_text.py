"""The landing of a plan as lines for a flyer."""

import math
from collections.abc import Iterator

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.recovery import Recovery
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.physics.history import recorded_wind
from fieldkit.planning.descent_rate import DEFAULT_DESCENT_SD, Fall
from fieldkit.planning.flown_descent import air_at_pads, landing_mass
from fieldkit.planning.landing import ELLIPSE_LEVEL, TRIED_WINDS, Landing, RailChoice, profile_in_words
from fieldkit.planning.planned_flight import PlannedFlight
from fieldkit.planning.quantiles import Three, three, three_of_all
from fieldkit.presentation.forecast_text import build_in_words, rests_in_words
from fieldkit.quantities import ShownUnits, counted, percent
from fieldkit.units import DEGREE

LEAST_CHANCE = 0.01
"""Minimum chance that is reported. [1]"""
NO_FLIGHT = "  landing   none: the motor does not lift the rocket off the rail"
"""Line in place of the landing of a rocket that is too heavy for its motor."""
OFF_AXIS = 0.05
"""Crosswind offset of the ellipse's center below which it is within the noise of the draws, relative to the short
semi-axis. [1]"""


def landing_in_words(planned: PlannedFlight, site: Site, system: str = "SI") -> Iterator[str]:
    """Landing, duration, the basis of the descent, and the recommended rail angle, in the units of a system."""
    prediction, down, fall, rail = planned.prediction, planned.down, planned.fall, planned.rail
    plan, recovery, shown = prediction.plan, prediction.plan.columns.recovery, ShownUnits(system)
    yield build_in_words(prediction)
    if prediction.stays_on_rail:
        yield NO_FLIGHT
        yield f"  based on  {rests_in_words(prediction)}"
        return
    yield from _place(down, site, shown) if down.wind is not None else _unknown_place(down, site, shown, planned.holds)
    yield f"  duration  {seconds_in_words(three(down.duration))}"
    falls = "" if down.landing_speed is None else f"at {shown.speed(down.landing_speed[1])}; "
    yield f"  landing   {falls}{_device(prediction, fall, recovery, shown)}"
    if (above := float(np.mean(prediction.true_apogee < (recovery.main_altitude or 0.0)))) >= LEAST_CHANCE:
        yield f"            {percent(above)} chance of an apogee below that: the main opens at apogee"
    if (ballistic := float(down.down.ballistic.mean())) >= LEAST_CHANCE:
        yield f"            {ballistic:.0%} hit the ground before deployment"
    yield f"  descent   {descent_in_words(fall, plan)}"
    yield f"  based on  {rests_in_words(prediction)}"
    if plan.wind is None:
        yield "  wind      not given: use --wind for the pad, --wind-aloft for higher up"
        return
    yield f"  wind      {profile_in_words(recorded_wind(plan), shown)}"
    if not rail:
        yield f"  recommended rail: none: {planned.no_rail}"
        return
    others = ", ".join(f"{_rail(one)}: {shown.length(one.away[1])}" for one in rail[1:4])
    yield f"  recommended rail: {rail_in_words(rail[0], shown)}; {others}"


def seconds_in_words(duration: Three | None) -> str:
    """The duration of a flight: `24.1 s, 90% interval 20.0 to 30.2`. `duration` is in [s]."""
    if duration is None:
        return "none: the motor does not lift the rocket"
    low, middle, high = duration
    return f"{middle:.1f} s, 90% interval {low:.1f} to {high:.1f}"


def rail_in_words(choice: RailChoice, shown: ShownUnits) -> str:
    """`7.5° into the wind, lands 87 m away`."""
    of_it = {"away": " from the wind"}.get(choice.direction, " the wind") if choice.angle else ""
    return f"{_rail(choice)}{of_it}, lands {shown.length(choice.away[1])} away"


def _rail(choice: RailChoice) -> str:
    return f"{choice.angle / DEGREE:.1f}° {choice.direction}" if choice.angle else "vertical"


def _place(down: Landing, site: Site, shown: ShownUnits) -> Iterator[str]:
    """The landing of a plan in the given wind."""
    low, middle, high = three_of_all(down.away)
    yield f"  lands     {shown.length(middle)} from the pad, 90% interval {shown.lengths(low, high)}"
    ellipse = down.ellipse()
    way = "downwind" if ellipse.along >= 0 else "upwind"
    axes = f"{shown.length(2 * ellipse.long)} by {shown.length(2 * ellipse.short)}"
    center = f"centered {shown.length(abs(ellipse.along))} {way}"
    if abs(ellipse.across) > OFF_AXIS * ellipse.short:
        center += f" and {shown.length(abs(ellipse.across))} to the {'right' if ellipse.across > 0 else 'left'}"
    yield f"  ellipse   {ELLIPSE_LEVEL:.0%} of landings: {axes}, {center}"
    if site.size is not None:
        inside = float((down.away <= site.size / 2).mean())
        chance = f"{percent(inside)} chance of landing on it (pad in the middle)"
        yield f"  field     {shown.length(site.size)} across: {chance}"


def _unknown_place(down: Landing, site: Site, shown: ShownUnits, holds: float | None) -> Iterator[str]:
    """The drift of a plan per unit of wind if none was given, and the highest wind with landings on the field."""
    low, middle, high = three_of_all(down.drift)
    yield f"  lands     unknown without the wind: drifts {shown.per_wind(middle)} at the pad"
    ends = shown.lengths(low * shown.speed_factor, high * shown.speed_factor)
    yield f"            on the way down, 90% interval {ends}"
    if site.size is not None and holds is not None:
        yield f"  field     {shown.length(site.size)} across: {_held(holds, shown)} (pad in the middle)"


def _held(wind: float, shown: ShownUnits) -> str:
    """The wind up to which landings stay on the field, as in `wind_that_holds`."""
    if not wind:
        return "fewer than 95% of landings are on it even in calm air"
    if math.isinf(wind):
        return f"95% of landings are on it in any wind up to {shown.speed(float(TRIED_WINDS[-1]))}"
    return f"95% of landings are on it up to {shown.speed(wind)}"


def _device(prediction: Prediction, fall: Fall, recovery: Recovery, shown: ShownUnits) -> str:
    if not recovery.main_altitude or fall.drogue is None:
        return f"one {recovery.device}"
    density = float(air_at_pads([prediction.plan]).density[0])
    speed = fall.drogue.usual_speed(landing_mass(prediction.plan, prediction.found), density)
    basis = f" assumed, ± {DEFAULT_DESCENT_SD:.0%}" if fall.drogue.assumed else ""
    return f"drogue at apogee, {shown.speed(speed)}{basis}, main at {shown.length(recovery.main_altitude)}"


def descent_in_words(fall: Fall, plan: Flight) -> str:
    """What the descent speed is based on, and without a measured one, how much a flight would narrow it."""
    if fall.flights:
        return f"fitted to {counted(fall.flights, 'flight')} with a duration or descent speed"
    narrower = 1 - fall.relative_sd(1) / fall.relative_sd()
    basis = (
        entered_in_words(plan.columns.recovery)
        if fall.typed
        else f"assumes a typical parachute or streamer, ± {DEFAULT_DESCENT_SD:.0%}"
    )
    return f"{basis}; one flight with a duration would narrow the descent speed by {narrower:.0%}"


def entered_in_words(recovery: Recovery) -> str:
    """Which entered value gives the descent speed: the speed itself rather than the diameter of the parachute."""
    if recovery.main_speed is None:
        return "diameter of the parachute as entered"
    unused = " and not its diameter" if recovery.parachute_diameter is not None else ""
    return f"speed under the parachute as entered{unused}"
