"""Where a plan lands as lines for a flyer."""

from collections.abc import Iterator, Sequence

from fieldkit.flight.recovery import recovery_of
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.planning.check import length, speed
from fieldkit.planning.descent import wind_profile
from fieldkit.planning.descent_rate import DEFAULT_DESCENT_SD, Fall
from fieldkit.planning.landing import ELLIPSE_LEVEL, Landing, RailChoice, profile_in_words
from fieldkit.planning.quantiles import three
from fieldkit.presentation.forecast_text import rests_in_words
from fieldkit.quantities import counted
from fieldkit.units import DEGREE


def landing_in_words(
    said: Prediction, down: Landing, fall: Fall, rail: Sequence[RailChoice], site: Site
) -> Iterator[str]:
    """Landing, duration, what the descent rests on, and the rail that is recommended."""
    plan, recovery = said.plan, recovery_of(said.plan)
    name = " ".join(part for part in (plan.rocket, plan.config) if part)
    yield f"{name} on {said.found.motor.maker} {said.found.motor.designation}"
    low, middle, high = three(down.away)
    yield f"  lands     {length(middle)} from the pad, 90 % interval {low:.0f} to {high:.0f} m"
    ellipse = down.ellipse()
    side = "right" if ellipse.across >= 0 else "left"
    yield (
        f"  ellipse   {ELLIPSE_LEVEL:.0%} of landings: {2 * ellipse.long:.0f} by {2 * ellipse.short:.0f} m, centered "
        f"{ellipse.along:.0f} m downwind and {abs(ellipse.across):.0f} m to the {side}"
    )
    if site.size is not None:
        inside = float((down.away <= site.size / 2).mean())
        yield f"  field     {length(site.size)} across: {inside:.0%} chance to land on it (pad in the middle)"
    low, middle, high = three(down.duration)
    yield f"  duration  {middle:.1f} s, 90 % interval {low:.1f} to {high:.1f}"
    falls = speed(three(down.down.landing_speed)[1])
    yield f"  landing   at {falls}; {_device(recovery.device, recovery.main_altitude)}"
    if (ballistic := float(down.down.ballistic.mean())) >= 0.005:
        yield f"            {ballistic:.0%} hit the ground before anything opens"
    yield f"  descent   {descent_in_words(fall)}"
    yield f"  based on  {rests_in_words(said)}"
    yield f"  wind      {profile_in_words(wind_profile(plan))}"
    if plan.wind is None:
        yield "            no wind given: use --wind for the pad, --wind-aloft for higher up"
        return
    best = rail[0]
    yield (
        f"  recommended rail: {best.angle / DEGREE:.1f}° {best.direction} the wind, lands {length(best.away[1])} away; "
        + ", ".join(f"{one.angle / DEGREE:.1f}° {one.direction}: {one.away[1]:.0f} m" for one in rail[1:4])
    )


def _device(device: str, main_altitude: float | None) -> str:
    return f"drogue at apogee, main at {length(main_altitude)}" if main_altitude else f"one {device}"


def descent_in_words(fall: Fall) -> str:
    """What the descent speed rests on, and without a flight that shows it how much one would narrow it."""
    if fall.flights:
        return f"fitted to {counted(fall.flights, 'flight')} with a duration or descent speed"
    narrower = 1 - fall.relative_sd(1) / fall.relative_sd()
    basis = "speed or parachute as entered" if fall.typed else f"assumes a usual device, ± {DEFAULT_DESCENT_SD:.0%}"
    return f"{basis}; one flight with a duration would narrow the descent speed by {narrower:.0%}"
