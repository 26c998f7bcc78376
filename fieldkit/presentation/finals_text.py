"""The table of finals: mass and parachute for each target, on one card."""

import datetime
from collections.abc import Iterator, Sequence
from typing import Any

from fieldkit.planning.air import air_of
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.finals import FinalsPlan
from fieldkit.planning.quantiles import named
from fieldkit.presentation.forecast_text import motor_in_words, rests_in_words
from fieldkit.presentation.landing_text import descent_in_words
from fieldkit.quantities import ShownUnits
from fieldkit.units import FOOT


def finals_headers(fall: Fall, system: str = "SI") -> tuple[str, ...]:
    """The headers of the table: heights in feet, as in the rules, masses in the unit of the second; without a measured
    descent, no parachute and no duration, and the points of the altitude alone."""
    mass = ShownUnits(system).mass(0.0).split()[1]
    first = "target ft", f"dry {mass}", "change", "lift-off"
    return (
        (*first, "apogee ft", "altitude points")
        if fall.assumed
        else (*first, "parachute", "apogee ft", "seconds", "points")
    )


def finals_rows(finals: FinalsPlan, system: str = "SI") -> list[tuple[str, ...]]:
    """One row per target; the change is against the dry mass of the plan."""
    shown, plan, fall = ShownUnits(system), finals.plan, finals.flown.fall
    return [
        (
            f"{one.target / FOOT:.0f}",
            shown.mass(one.mass).split()[0],
            _signed(one.mass - (plan.flight.dry_mass or one.mass), shown),
            shown.mass(one.mass + plan.found.motor.loaded_mass).split()[0],
            *(() if fall.assumed else (f"{one.area:.0%}{'*' if one.at_edge else ''}",)),
            f"{one.apogee[0] / FOOT:.0f}-{one.apogee[2] / FOOT:.0f}",
            *(
                ()
                if fall.assumed
                else ("" if one.duration is None else f"{one.duration[0]:.0f}-{one.duration[2]:.0f}",)
            ),
            f"{one.points:.0f}{'*' if fall.assumed and one.at_edge else ''}",
        )
        for one in finals.table
    ]


def _signed(mass: float, shown: ShownUnits) -> str:
    """A change of mass [kg] with its sign, without the unit."""
    return ("+" if mass > 0 else "") + shown.mass(mass).split()[0]


def finals_document(finals: FinalsPlan) -> list[dict[str, Any]]:
    """The rows of the table of finals, with the unit in the key."""
    plan, fall = finals.plan, finals.flown.fall
    return [
        {
            "target_ft": one.target / FOOT,
            "dry_mass_g": one.mass * 1e3,
            "change_g": (one.mass - (plan.flight.dry_mass or one.mass)) * 1e3,
            "lift_off_mass_g": (one.mass + plan.found.motor.loaded_mass) * 1e3,
            "parachute_area": None if fall.assumed else one.area,
            "apogee_ft": one.apogee[1] / FOOT,
            "apogee_m": named(one.apogee),
            "duration_s": named(one.duration)["p50"],
            "duration": named(one.duration),
            "points": one.points,
            "at_edge": one.at_edge,
        }
        for one in finals.table
    ]


def finals_lines(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """The table as lines of text, numbers below the ends of their headers."""
    widths = [max(map(len, column)) for column in zip(headers, *rows, strict=True)]
    for cells in (headers, *rows):
        yield "  ".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True))


def finals_heading(finals: FinalsPlan, system: str = "SI") -> Iterator[str]:
    """Rocket, motor, season, and the day with its weather in the units of a system, above the table; and that the
    parachute is assumed, if it is."""
    shown, plan, rule = ShownUnits(system), finals.plan.flight, finals.rule
    name = f"{plan.rocket or 'this rocket'} {plan.config}".rstrip()
    opens, closes = rule.window
    motor = motor_in_words(plan, finals.plan.found)
    yield f"{name} on {motor}, season {rule.year}, window {opens:g} to {closes:g} s"
    temperature = "standard" if plan.temperature is None else shown.temperature(plan.temperature)
    wind = "not given" if plan.wind is None else shown.speed(plan.wind)
    day = (plan.date_time or datetime.datetime.now()).date().isoformat()
    yield f"{day}, temperature {temperature}, wind {wind}; {air_of(plan).words(system)}"
    if finals.flown.fall.assumed:
        yield (
            "no parachute is advised, and only the altitude is scored: the descent is not measured; time a flight, or "
            "give the descent speed under it, or its diameter"
        )


def finals_notes(finals: FinalsPlan) -> Iterator[str]:
    """What the table is based on, how much one more flight at its middle target would narrow it, what the season's
    rules say of finals, and what is checked by hand."""
    flown, table, rule = finals.flown, finals.table, finals.rule
    prediction, fall = flown.forecast_at(table[len(table) // 2].mass), flown.fall
    yield f"based on {rests_in_words(prediction)}; descent: {descent_in_words(fall, prediction.plan)}"
    apogee = f"the apogee by {1 - prediction.narrowed(1):.0%}" if prediction.rests_on else ""
    descent = f"the descent speed by {1 - fall.relative_sd(1) / fall.relative_sd():.0%}" if fall.flights else ""
    if narrower := " and ".join(part for part in (apogee, descent) if part):
        yield f"one more flight with a duration would narrow {narrower}"

    if rule.finals:
        yield f"finals: {rule.finals}"
    yield from (f"{name}: {text}" for name, text in rule.by_hand)
    yield rule.caveat


def finals_failures(lines: Sequence[SafetyCheck]) -> str:
    """The checks of the table that failed, for the card, which has no room for all; empty if none did."""
    failed = ", ".join(f"{line.name} ({line.verdict})" for line in lines if line.failed)
    return f"checks that are not ok: {failed}" if failed else ""


ENDS_NOTE = "Checks are those of the lightest or the heaviest flight of the table, whichever is worse."
"""Line next to the safety checks of the finals."""
FINALS_NOTES = (
    "change: against the mass of the plan. parachute: area relative to the one flown or entered. "
    "*: at the limit of the masses and areas tried; a wider range may be better. "
    "apogee, seconds: 5 to 95%. points: mean per flight.",
    "Weigh on the pad; the altimeter's reading counts.",
)
