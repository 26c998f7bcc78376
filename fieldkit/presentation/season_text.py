"""A contest season as steps: what is done, what is missing, and the command or key that does it."""

from collections.abc import Sequence
from dataclasses import dataclass
from shlex import quote

from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.short_name import short_name
from fieldkit.messages import message
from fieldkit.planning.check import BY_EYE
from fieldkit.planning.contest import Scored, Season
from fieldkit.planning.contest_flight import judged_duration, why_no_score
from fieldkit.planning.practice import Practice, PracticePlan
from fieldkit.planning.quantiles import three_of_all
from fieldkit.presentation.forecast_text import motor_in_words
from fieldkit.quantities import ShownUnits, counted, in_system, measure, percent
from fieldkit.services.season_guide import SeasonGuide
from fieldkit.units import FOOT, ZERO_CELSIUS

WARM_DAY = ZERO_CELSIUS + 25
"""Temperature in the example of a command. [K]"""
SeasonStep = tuple[str, str, tuple[str, ...]]
"""A step: its name, its state in a word or two, and its lines."""


@dataclass(frozen=True, slots=True)
class SeasonWays:
    """How a reader does what a step asks for, by commands or by keys: add a flight, enter a parachute, compare motors,
    print the card of finals for a plan."""

    add: str
    parachute: str
    motors: str
    finals: str


def season_commands(plan: Flight, year: int, system: str = "SI") -> SeasonWays:
    """The commands for a plan and a season, with the temperature of a warm day in the units of a system."""
    options = [("rocket", plan.rocket), ("motor", plan.motor)]
    given = " ".join(f"--{name} {quote(text)}" for name, text in options if text)
    day = measure(BY_NAME["temperature"], WARM_DAY, system).replace(" °", "").lower()  # 25c, 77f
    return SeasonWays(
        add="`fieldkit add --apogee --timer-1-s`",
        parachute="give --parachute-diameter",
        motors="`fieldkit motors --fit`",
        finals=f"`fieldkit finals {given} --season {year} --temperature {day} --card finals.pdf`",
    )


def season_steps(guide: SeasonGuide, ways: SeasonWays, system: str = "SI") -> list[SeasonStep]:
    """The steps of a season, in order, in the units of a system; heights in feet, as in the rules."""
    shown, rule = ShownUnits(system), guide.rule
    return [
        _rules(rule),
        _limits(guide, system),
        _tests(guide.scored, rule, ways),
        _setting(guide, ways, shown),
        _practice(guide.practice, shown),
        _qualification(guide),
        _finals(rule, ways),
    ]


def rule_lines(rule: Season) -> tuple[str, ...]:
    """The rules of a season: its target, its points, what the program checks, what it cannot, and where they are
    from."""
    figures = (("g on the pad", rule.mass, 1e3), ("N s", rule.impulse, 1.0))
    limits = [f"at most {value * scale:g} {unit}" for unit, value, scale in figures if value is not None]
    limits += [f"at least {rule.length * 1e3:g} mm long"] if rule.length is not None else []
    points = f"{rule.per_metre * FOOT:g} point for each foot off the target"
    late = f"{rule.per_second:g} for each second outside the window"
    checked = (f"points: {points}, {late}", *([f"limits: {', '.join(limits)}"] if limits else []))
    return (_target(rule), *checked, *_unchecked(rule))


def _target(rule: Season) -> str:
    opens, closes = rule.window
    return f"{rule.target / FOOT:.0f} ft in {opens:g} to {closes:g} s; the best {rule.best} of {rule.declared} declared"


def _unchecked(rule: Season) -> list[str]:
    """The rules that the program cannot check, and the source of all."""
    return [*(f"{name}: {text}" for name, text in rule.by_hand), *([rule.caveat] if rule.caveat else [])]


def _rules(rule: Season) -> SeasonStep:
    state = "checked" if rule.checked else "not checked"
    return f"rules of {rule.year}", state, (_target(rule), *_unchecked(rule))


def _limits(guide: SeasonGuide, system: str) -> SeasonStep:
    lines, plan = guide.lines, guide.plan.flight
    contest = [line for line in lines if line.name.startswith("contest ") and not line.finding.startswith(BY_EYE)]
    failed = [line for line in lines if line.failed]
    open_ones = [line for line in contest if line.verdict == "unknown"]
    state = f"{len(failed)} not ok" if failed else "ok" if not open_ones else f"{len(open_ones)} to check"
    texts = [f"{plan.rocket} {plan.config}".strip() + f" on {motor_in_words(plan, guide.plan.found)}"]
    texts += [
        in_system(message(f"{line.name}: {line.verdict}, {line.finding}"), system) for line in (*failed, *open_ones)
    ]
    return "rocket and motor", state, tuple(dict.fromkeys(texts))


def _tests(scored: Sequence[Scored], rule: Season, ways: SeasonWays) -> SeasonStep:
    timed = [flight for flight, _ in scored if judged_duration(flight) is not None]
    weighed = [flight for flight, _ in scored if flight.dry_mass is not None]
    texts = []
    if not scored:
        texts.append(f"fly it once as built, weighed at the pad with its eggs: {ways.add}")
    elif len(timed) < len(scored):
        texts.append(f"{len(scored) - len(timed)} without a time: time every flight with two watches")
    if len(weighed) < len(scored):
        texts.append(f"{len(scored) - len(weighed)} without a mass: no fit uses them")
    best = min((points for _, points in scored if points is not None), default=None)
    if best is not None:
        texts.append(f"best of them by the rule of {rule.year}: {best:.1f}")
    return "test flights", f"{len(scored)} flown, {len(timed)} timed", tuple(texts)


def _setting(guide: SeasonGuide, ways: SeasonWays, shown: ShownUnits) -> SeasonStep:
    plan, now, row = guide.plan, guide.now, guide.now.row
    change = row.mass - (plan.flight.dry_mass or row.mass)
    sign = "+" if change > 0 else ""
    lift_off = shown.mass(row.mass + plan.found.motor.loaded_mass)
    texts = [
        f"dry mass {shown.mass(row.mass).split()[0]} ± {shown.mass(now.mass_sd)} "
        f"({sign}{shown.mass(change)} against the plan), {lift_off} at lift-off"
    ]
    if now.area_sd is None:
        texts.append(f"parachute: no flight is timed, so nothing is advised; time one, or {ways.parachute}")
    else:
        texts.append(f"parachute {row.area:.0%} ± {now.area_sd:.0%} of its present area")
    low, _, high = row.apogee
    seconds = (
        "" if row.duration is None or now.area_sd is None else f", {row.duration[0]:.1f} to {row.duration[2]:.1f} s"
    )
    texts.append(
        f"then {low / FOOT:.0f} to {high / FOOT:.0f} ft{seconds} (90%), {counted(round(row.points), 'point')} a flight "
        "on average"
    )
    if row.at_edge:
        texts.append(f"this is at the limit of the masses tried: another motor may meet the target, {ways.motors}")
    texts.append(f"based on {counted(guide.ahead.forecast.rests_on, 'flight')}")
    return "mass and parachute together", "", tuple(texts)


def _practice(practice: Practice, shown: ShownUnits) -> SeasonStep:
    before, best, worst = practice.plans[0], practice.single[0], practice.single[-1]
    now, then = f"{before.apogee_sd:.1%}", f"{best.apogee_sd:.1%}"
    known = f"known to {then} instead of {now}" if then != now else f"known to {now}, as now"
    texts = [f"the next: timed, at a dry mass of {shown.mass(best.masses[0])}: a finals apogee is then {known}"]
    if worst.apogee_sd - best.apogee_sd < 0.02 * best.apogee_sd:
        texts.append("any mass between those of the finals narrows it as much, so fly the one you need")
    texts += [_planned(one, shown) for one in practice.plans]
    return "practice", f"{counted(round(before.points), 'point')} in a finals flight now", tuple(texts)


def _planned(one: PracticePlan, shown: ShownUnits) -> str:
    masses = list(dict.fromkeys(shown.mass(mass) for mass in one.masses))
    at = f" at {', '.join(masses if len(masses) == 1 else map(shown.mass, one.masses))}" if masses else ""
    when = f"after {counted(len(one.masses), 'more flight')}{at}" if one.masses else "now"
    return (
        f"{when}: apogee ± {one.apogee_sd:.1%}, descent ± {one.descent_sd:.0%}, {counted(round(one.points), 'point')}"
    )


def _qualification(guide: SeasonGuide) -> SeasonStep:
    rule, scores, declared, cut = guide.rule, guide.scores, guide.day.declared, guide.day.cut
    by_id = {flight.flight_id: (flight, points) for flight, points in guide.scored}
    texts = []
    for name in declared:
        if name not in by_id:
            texts.append(f"{name}: not among the flights of this rocket that have an apogee")
            continue
        flight, points = by_id[name]
        own = f"no score, {why_no_score(flight, rule.egg_count)}" if points is None else f"{points:.2f}"
        texts.append(f"{short_name(flight)}: {own}")
    known = sorted(points for name in declared if name in by_id and (points := by_id[name][1]) is not None)
    if len(known) >= rule.best:
        texts.append(f"score so far: {sum(known[: rule.best]):.2f}")
    if scores is not None:
        low, middle, high = three_of_all(scores)
        texts.append(
            f"the score at the end, if the others fly with mass and parachute as above: {middle:.0f} "
            f"({low:.0f} to {high:.0f})"
        )
    if scores is not None and cut is not None:
        texts.append(f"chance of a score up to {cut:g}: {percent(float((scores <= cut).mean()))}")
    left = max(rule.declared - len(declared), 0)
    return "qualification", f"{len(declared)} of {rule.declared} declared, {left} left", tuple(texts)


def _finals(rule: Season, ways: SeasonWays) -> SeasonStep:
    texts = [rule.finals] if rule.finals else []
    texts.append(f"the card for every target, in the day's air: {ways.finals}")
    return "finals", "", tuple(texts)
