"""Delays, ballast and contest outlooks as lines for a flyer: the result, its uncertainty, and its basis."""

from collections.abc import Iterator

from fieldkit.flight import BY_NAME, Flight
from fieldkit.messages import message
from fieldkit.physics.setups import RAIL_LENGTH
from fieldkit.planning.air import air_of
from fieldkit.planning.ballast import Ballast, Goal
from fieldkit.planning.contest import Season
from fieldkit.planning.delay import Delay, Delays, Drill
from fieldkit.planning.gain import LEAST_GAIN
from fieldkit.planning.motor_advice import MotorAdvice
from fieldkit.planning.outlook import Outlook
from fieldkit.planning.quantiles import three, three_of_all
from fieldkit.presentation.forecast_text import build_in_words, rests_in_words
from fieldkit.presentation.landing_text import descent_in_words, seconds_in_words
from fieldkit.quantities import ShownUnits, in_system, measure, percent
from fieldkit.rocket import Rocket
from fieldkit.units import DEGREE, FOOT, parse

FLIGHT_CONDITIONS = ("wind", "rail_length", "rail_angle")
"""Conditions of a flight, besides the air."""
RAIL_WAYS = {
    0: "into the wind",
    180: "away from the wind",
    90: "across the wind, to its right",
    270: "across the wind, to its left",
}
"""Directions of a slanted rail, in degrees to the right of into the wind."""


BREEZE, IN_A_BREEZE = 4.47, "by 4 to 9%"
"""A wind [m/s], and how much it lowers an apogee: `fieldkit simulate` of F24-4W (322 g, 66 mm), A8-3 (40 g, 25 mm) and
C6-5 (60 g, 25 mm), with a Cd of 0.6."""
OFF_VERTICAL = "by 0.8 to 1%"
"""How much a rail 5 degrees off vertical lowers an apogee of the same flights, without wind."""


def conditions_in_words(
    plan: Flight, rocket: Rocket | None = None, system: str = "SI", *, brief: bool = False
) -> Iterator[str]:
    """A plan's air and its effect on the altimeter, its other conditions, and the design whose Cd it starts from if the
    `rocket` has one; in the units of a system. `brief` leaves out by how much another air or rail
    angle than the one assumed changes the apogee."""
    air = air_of(plan)
    other = f" ({air.other(system)})" if air.assumed and not brief else ""
    yield f"  air       {air.words(system)}{other}"
    wind, rod, angle = (measure(BY_NAME[name], plan.number(name), system) for name in FLIGHT_CONDITIONS)
    usual = measure(BY_NAME["rail_length"], RAIL_LENGTH, system)
    rail = f"rail {rod or f'{usual} (default)'}"
    breeze = measure(BY_NAME["wind"], BREEZE, system)
    blows = f"wind {wind}" if wind else f"wind not given (from calm to {breeze} the apogee falls {IN_A_BREEZE})"
    slanted = f"at {(angle or '').removeprefix('-')} {_way(plan)}"
    tilted = "" if brief else f"; 5° off lowers the apogee {OFF_VERTICAL}"
    upright = "vertical" if angle else f"vertical (default{tilted})"
    yield f"  with      {blows}, {rail}, {slanted if plan.rail_angle else upright}"
    design = rocket.design(plan.config) if rocket is not None else None
    if design is not None and design.cd:
        yield f"  design    initial Cd {design.cd:.2f} from {design.source}"


def _way(plan: Flight) -> str:
    """The direction of a slanted rail: `into the wind`; a negative angle points the other way."""
    opposite = 180 if (plan.rail_angle or 0.0) < 0 else 0
    degrees = (round(plan.columns.rail_direction / DEGREE) + opposite) % 360
    return RAIL_WAYS.get(degrees, f"{degrees}° to the right of into the wind")


LEAST_LISTED = 0.01
"""Lowest probability of a flight that hits the ground before its charge fires that is listed. [1]"""


def delays_in_words(judged: Delays, fast: float, tool: Drill | None = None, system: str = "SI") -> Iterator[str]:
    """The coast time, and every delay from best to worst; `fast` is the speed limit at ejection [m/s].

    `tool` is the delay drilling tool; figures are in the units of a `system`.
    """
    shown = ShownUnits(system)
    prediction = judged.forecast
    p05, p50, p95 = judged.coast
    build = " ".join(part for part in (prediction.plan.rocket, prediction.plan.config) if part)
    motor = f"{prediction.found.motor.maker} {prediction.found.motor.designation}"
    yield f"{build} on {motor}: coasts {p50:.1f} s from burnout to apogee"
    yield f"  90% interval {p05:.1f} to {p95:.1f} s; based on {rests_in_words(prediction)}"
    if judged.delays:
        yield f"  {'delay':<7}  {'after apogee':>12}  {'5 to 95%':>12}  {'speed':>8}  {'too fast':>8}"
    yield from (f"  {_delay(one, shown)}" for one in judged.delays)
    yield from (f"  {words}" for words in judged.words)
    if tool is not None and tool.caveat and not all(one.on_sale for one in judged.delays):
        yield f"  {in_system(message(tool.caveat), system)}"
    if any(not one.on_sale for one in judged.delays):
        yield "  *: drilled from the longest delay with the maker's tool."
    if any(one.lands_first >= LEAST_LISTED and one.after_apogee for one in judged.delays):
        yield "  Some flights hit the ground before the charge and count as too fast: time and speed are of the others."
    yield f"  Too fast: over {shown.speed(fast, 0)}. Assumes delays vary by up to 20%, 1.5 to 3 s (NFPA 1125)."
    if judged.delays:
        first = judged.delays[0]
        drilled = "" if first.on_sale else ", drilled"
        yield f"  best      {first.delay:g} s{drilled}, the least likely to open too fast ({percent(first.too_fast)})"


def ballast_in_words(best: Ballast, goal: Goal, system: str = "SI") -> Iterator[str]:
    """The mass to fly, its result compared with the current mass, and the reachable range if the target cannot be met;
    in the units of a system, except the points and feet of a contest. If no change is advised, only the current mass
    and its result."""
    prediction, shown = best.advised, ShownUnits(system)
    p05, p50, p95 = three_of_all(prediction.apogee)
    result = best.there if best.clear else best.today
    yield f"{build_in_words(prediction)}, target {shown.length(goal.target)}"
    if best.too_heavy and goal.rule is not None and goal.rule.mass is not None:
        yield f"  too heavy: the season allows at most {shown.mass(goal.rule.mass)} on the pad"
    if not best.clear:
        gain, error = (
            (f"{best.gain:.0f}", f"{best.gain_error:.0f} points")
            if goal.rule is not None
            else (shown.length(best.gain * FOOT).split()[0], shown.length(best.gain_error * FOOT))
        )
        yield f"  advice    no change: a gain of {gain} ± {error} per flight is not significant"
        yield "            one more flight at the current mass would help"
    change = f"{'add' if best.add >= 0 else 'remove'} {shown.mass(abs(best.add))}" if best.clear else "no change"
    yield f"  dry mass  {shown.mass(best.mass if best.clear else best.mass - best.add)}: {change}"
    yield f"  apogee    {shown.length(p50)} as the altimeter will show it"
    yield f"            90% interval {shown.lengths(p05, p95)}"
    yield f"  true      {shown.length(three_of_all(prediction.true_apogee)[1])} above the pad"

    def without(value: str) -> str:
        return f" ({value} without change)" if best.clear else ""

    yield f"  within    {shown.length(goal.within)}: {percent(result.chance)}{without(percent(best.today.chance))}"
    yield f"  mean miss {shown.length(result.error)}{without(shown.length(best.today.error))}"
    if result.points is not None and best.today.points is not None:
        yield f"  points    {result.points:.0f} per flight, with duration{without(f'{best.today.points:.0f}')}"
    step = "1 g" if shown.mass(0.0).endswith(" g") else "1 oz"
    yield f"  {f'{step} more':9} {shown.difference(best.slope * parse(step, 'mass', 'g'))}"
    yield f"  based on  {rests_in_words(prediction)}"
    if goal.rule is not None and goal.rule.caveat:
        yield f"  {goal.rule.caveat}"
    if not best.met:
        least, most = (shown.length(height) for height in best.reach)
        yield f"  Out of reach: with these masses the median altimeter apogee is {least} to {most}."


def outlook_in_words(
    ahead: Outlook, rule: Season, area: float, cut: float | None = None, system: str = "SI"
) -> Iterator[str]:
    """Expected points and score, the duration, and the parachute with the fewest expected points; heights in feet, as
    in contests, the true one in the units of a system."""
    prediction = ahead.forecast
    low, middle, high = three_of_all(ahead.points.ravel())
    sums = rule.sums(ahead.points)
    least, _, most = three_of_all(sums)
    mass = ShownUnits(system).mass(prediction.plan.dry_mass or 0.0)
    yield f"{build_in_words(prediction)}, {mass} without the motor, season {rule.year}"
    yield (
        f"  points    {ahead.points.mean():.0f} per flight, 90% interval {low:.0f} to {high:.0f}, median {middle:.0f}"
    )
    yield (
        f"  score     {sums.mean():.0f} for the best {rule.best} of {rule.declared}, "
        f"90% interval {least:.0f} to {most:.0f}"
    )
    low, middle, high = (height / FOOT for height in three_of_all(prediction.apogee))
    aimed = f"target {rule.target / FOOT:.0f} ft"
    yield f"  apogee    {middle:.0f} ft on the altimeter, 90% interval {low:.0f} to {high:.0f}, {aimed}"
    yield f"  true      {three_of_all(prediction.true_apogee)[1] / FOOT:.0f} ft above the pad"
    opens, closes = rule.window
    yield f"  duration  {seconds_in_words(three(ahead.duration.ravel()))}, window {opens:g} to {closes:g} s"
    yield f"  descent   {descent_in_words(ahead.fall, prediction.plan)}"
    yield f"  parachute {area:.0%} of the area flown"
    yield from _better_parachute(ahead, ShownUnits(system))
    yield f"  based on  {rests_in_words(prediction)}"
    if cut is not None:
        chance = ahead.chance(rule, cut)
        yield f"  chance that the best {rule.best} of {rule.declared} sum to {cut:g} or less: {percent(chance)}"
    if rule.caveat:
        yield f"  {rule.caveat}"


def _better_parachute(ahead: Outlook, shown: ShownUnits) -> Iterator[str]:
    """The area with the fewest expected points, if the descent is measured and it saves one per flight, and whether a
    change to it is advised."""
    if ahead.fall.assumed or ahead.gain < LEAST_GAIN:
        return
    edge = " of the area flown, the limit of the areas tried," if ahead.at_edge else ""
    saves = f"{ahead.area:.0%}{edge} would lower the points per flight by {ahead.gain:.0f} ± {ahead.gain_error:.0f}"
    lands = f"and land at {shown.speed(ahead.speed_there)}"
    if ahead.clear:
        yield f"            {saves} {lands}"
    else:
        yield f"            no change advised: {saves}, which is not significant, {lands}"


MAX_ADVISED_MOTORS = 5
"""Maximum number of motors whose points are printed. [1]"""


def advice_in_words(advice: MotorAdvice, rule: Season, *, listed: bool) -> Iterator[str]:
    """The motors with the fewest expected points, and whether a change of motor pays off. `listed` if the flyer has
    the season's motor list, so that only motors on it are ranked."""
    if not advice.ranked:
        yield f"season {rule.year}: no motor that fits is within the season's limits"
        return
    first = advice.ranked[0]
    best = ", ".join(f"{one.choice.motor.designation} {one.mean:.0f}" for one in advice.ranked[:MAX_ADVISED_MOTORS])
    yield f"season {rule.year}: expected points per flight at this mass: {best}"
    name = first.choice.motor.designation
    if advice.current is None or advice.gain is None:
        yield f"{name} scores the fewest; no flown motor to compare it with"
    elif advice.current.choice.motor is first.choice.motor:
        yield f"no change: {name}, flown last, scores the fewest"
    elif advice.clear:
        gain = f"{advice.gain:.0f} ± {advice.gain_error:.0f} points per flight fewer"
        yield f"change to {name}: {gain} than {advice.current.choice.motor.designation}"
    else:
        gain = f"{name} scores {advice.gain:.0f} ± {advice.gain_error:.0f} points per flight fewer"
        yield f"no change from {advice.current.choice.motor.designation}: {gain}, which is not significant"
    to_check = "the rule" if listed else "the season's motor list and the rule"
    motors = "only motors on your copy of the season's list; " if listed else ""
    yield f"{motors}check {to_check}; `fieldkit ballast --season` finds the mass"


def _delay(one: Delay, shown: ShownUnits) -> str:
    name = f"{one.delay:g} s" + ("" if one.on_sale else "*")
    if one.after_apogee is None or one.speed is None:
        return f"{name:<7}  the rocket hits the ground first"
    low, middle, high = (round(seconds, 1) + 0.0 for seconds in one.after_apogee)  # zero is never negative
    grounded = f"  {one.lands_first:.0%} hit the ground" if one.lands_first >= LEAST_LISTED else ""
    return (
        f"{name:<7}  {f'{middle:+.1f} s':>12}  {f'{low:+.1f} to {high:+.1f}':>12}"
        f"  {shown.speed(one.speed[1], 0):>8}  {one.too_fast:>8.0%}{grounded}"
    )
