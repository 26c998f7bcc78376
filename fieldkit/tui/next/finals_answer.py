"""The table of finals on the Decide screen: mass and parachute for each target that may be announced."""

from dataclasses import replace

from fieldkit.motors import Found
from fieldkit.paths import data_file
from fieldkit.planning.check import safety_text, strictest
from fieldkit.planning.contest_day import Day
from fieldkit.planning.contest_limits import allowed, approved_motors
from fieldkit.planning.descent_rate import fall_of
from fieldkit.planning.finals import end_flights, finals_table, finals_targets, trials
from fieldkit.planning.safety import safety_lines
from fieldkit.presentation.finals_text import (
    ENDS_NOTE,
    FINALS_NOTES,
    finals_basis,
    finals_headers,
    finals_heading,
    finals_lines,
    finals_rows,
)
from fieldkit.tui.next.answer import Answer
from fieldkit.tui.next.decisions import Decision, rule_of
from fieldkit.tui.next.next_words import folded, worst_first


def finals_answer(decision: Decision, year: int, day: Day) -> Answer:
    """The table of a plan's motor for the finals of a season, in the window of the day if one was announced.

    Raises ImpossibleFlight for a plan without a mass or with too little thrust.
    """
    rocket, plan, found = decision.rocket, decision.plan, Found(decision.motor, None)
    rule = rule_of(year).announced(None, day.window)
    flown = trials(rocket, plan, found, rule)
    table = finals_table(flown, rule, finals_targets(rule))
    ends = end_flights(rocket, plan, found, table)
    approved = approved_motors(rule.year, data_file("seasons"))
    checks = []
    for one, area in ends:
        fall = fall_of(rocket.history, one.plan, one.found).on_area(area)
        safety = safety_lines(one, decision.site, fall, decision.limits)
        checks.append([*safety, *allowed(rule, one.plan, found, day.length, approved)])
    words = (
        *finals_heading(replace(plan, rocket=plan.rocket or "this rocket"), found, rule, flown.fall, decision.system),
        "",
        *finals_lines(
            finals_headers(flown.fall, decision.system), finals_rows(table, plan, found, flown.fall, decision.system)
        ),
        "",
        *FINALS_NOTES,
        *finals_basis(flown, table),
        *([f"finals: {rule.finals}"] if rule.finals else []),
        *filter(None, [rule.caveat]),
    )
    lines = worst_first(strictest(*checks))
    return Answer(
        words,
        (ENDS_NOTE, "", *safety_text(lines, decision.system)),
        folded=(ENDS_NOTE, "", *folded(lines, decision.system)),
    )
