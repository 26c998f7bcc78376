"""Where a plan lands as lines for a flyer."""

from collections.abc import Iterator, Sequence

from fieldkit.flight.recovery import recovery_of
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.planning.check import length, speed
from fieldkit.planning.descent import Fall, wind_profile
from fieldkit.planning.landing import ELLIPSE_LEVEL, Landing, RailChoice, profile_in_words
from fieldkit.planning.quantiles import three
from fieldkit.presentation.forecast_text import rests_in_words
from fieldkit.units import DEGREE


def landing_in_words(
    said: Prediction, down: Landing, fall: Fall, rail: Sequence[RailChoice], site: Site
) -> Iterator[str]:
    """Landing, duration, what the descent rests on, and the rail that is recommended."""
    plan, recovery = said.plan, recovery_of(said.plan)
    name = " ".join(part for part in (plan.rocket, plan.config) if part)
    yield f"{name} on {said.found.motor.maker} {said.found.motor.designation}"
    low, middle, high = three(down.away)
    yield f"  lands     {length(middle)} from the pad, 90 % between {low:.0f} and {high:.0f} m"
    ellipse = down.ellipse()
    side = "right" if ellipse.across >= 0 else "left"
    yield (
        f"  ellipse   of {ELLIPSE_LEVEL:.0%}: {2 * ellipse.long:.0f} by {2 * ellipse.short:.0f} m, its middle "
        f"{ellipse.along:.0f} m downwind and {abs(ellipse.across):.0f} m to the {side}"
    )
    if site.size is not None:
        inside = float((down.away <= site.size / 2).mean())
        yield f"  field     {length(site.size)} across: {inside:.0%} land on it, the pad in its middle"
    low, middle, high = three(down.duration)
    yield f"  duration  {middle:.1f} s, 90 % between {low:.1f} and {high:.1f}"
    falls = speed(three(down.down.landing_speed)[1])
    yield f"  landing   at {falls}; {_device(recovery.device, recovery.main_altitude)}"
    if (ballistic := float(down.down.ballistic.mean())) >= 0.005:
        yield f"            {ballistic:.0%} reach the ground before anything is open"
    yield f"  descent   {_rests_on(fall)}"
    yield f"  rests on  {rests_in_words(said)}"
    yield f"  wind      {profile_in_words(wind_profile(plan))}"
    if plan.wind is None:
        yield "            no wind was given: --wind says what it is at the pad, --wind-aloft higher up"
        return
    best = rail[0]
    yield (
        f"  recommended rail: {best.angle / DEGREE:.1f}° {best.direction} the wind, lands {length(best.away[1])} away; "
        + ", ".join(f"{one.angle / DEGREE:.1f}° {one.direction}: {one.away[1]:.0f} m" for one in rail[1:4])
    )


def _device(device: str, main_altitude: float | None) -> str:
    return f"drogue at apogee, main at {length(main_altitude)}" if main_altitude else f"one {device}"


def _rests_on(fall: Fall) -> str:
    """What the descent speed rests on."""
    if not fall.flights:
        return "no flight told how fast this rocket comes down; one with a duration or a descent speed narrows it most"
    return f"fitted on {fall.flights} flight{'s' if fall.flights > 1 else ''} with a duration or a descent speed"
