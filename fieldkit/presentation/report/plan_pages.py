"""The pages of a plan, each one picture or PDF: the range card, the range safety sheet, and the card of finals."""

import datetime
from itertools import islice

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.planning.finals import FinalsPlan
from fieldkit.planning.planned_flight import PlannedFlight
from fieldkit.presentation.finals_text import finals_failures, finals_headers, finals_heading, finals_notes, finals_rows
from fieldkit.presentation.forecast_text import in_words
from fieldkit.presentation.landing_text import landing_in_words
from fieldkit.presentation.planning_text import conditions_in_words
from fieldkit.presentation.report.finals_card import finals_card
from fieldkit.presentation.report.range_card import range_card
from fieldkit.presentation.report.safety_sheet import safety_sheet
from fieldkit.rocket import Rocket

MAX_CARD_LINES = 30
"""Maximum number of lines of a range card above its safety checks. [1]"""


def range_card_of(one: PlannedFlight, rocket: Rocket, site: Site, suffix: str, system: str = "SI") -> bytes:
    """The range card of a planned flight, as a file with a suffix: its forecast, its landing, and its checks."""
    prediction = one.prediction
    name, *forecast = in_words(prediction, system)
    _, *down = landing_in_words(one, site, system)
    text = [
        name,
        _day(prediction.plan),
        *forecast,
        *(line for line in down if not line.startswith("  based on")),
        *conditions_in_words(prediction.plan, rocket, system),
        *(f"  note      {note}" for note in prediction.found.notes),
    ]
    return range_card(text[:MAX_CARD_LINES], one.lines, one.down, site, suffix, system)


def safety_sheet_of(one: PlannedFlight, rocket: Rocket, site: Site, suffix: str, system: str = "SI") -> bytes:
    """The range safety sheet of a planned flight, as a file with a suffix."""
    plan = one.prediction.plan
    title = islice(landing_in_words(one, site, system), 1)
    return safety_sheet([*title, _day(plan), *conditions_in_words(plan, rocket, system)], one.lines, suffix, system)


def finals_card_of(finals: FinalsPlan, suffix: str, system: str = "SI") -> bytes:
    """The card of finals of a plan, as a file with a suffix: the table, failed checks, and what is not known."""
    notes = [*filter(None, [finals_failures(finals.lines)]), *finals_notes(finals)]
    headers, rows = finals_headers(finals.flown.fall, system), finals_rows(finals, system)
    return finals_card(list(finals_heading(finals, system)), headers, rows, suffix, notes)


def _day(plan: Flight) -> str:
    """The date of a plan, by default today, and its site."""
    day = (plan.date_time or datetime.datetime.now()).date().isoformat()
    return f"  day       {day}, {plan.site or 'site not named'}"
