"""The day sheet: the plans of a day on paper, one row each, with their forecasts and room for their results.

Below the table are the safety checks that did not pass, by flight, for the check-in.
"""

from collections.abc import Sequence
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction, median
from fieldkit.motors import PLUGGED_DELAY
from fieldkit.physics.history import recorded_wind
from fieldkit.planning.air import air_of
from fieldkit.planning.check import ADVICE_NOTE, MARKS, SafetyCheck, Verdict
from fieldkit.planning.landing import profile_in_words
from fieldkit.planning.planned_flight import PlannedFlight
from fieldkit.planning.quantiles import three, three_of_all
from fieldkit.presentation.landing_text import rail_in_words
from fieldkit.presentation.report.style import bound, drawn, shortened, styled
from fieldkit.quantities import ShownUnits, counted
from fieldkit.safe_text import printable

HEADERS = (
    "flight",
    "rocket",
    "motor",
    "lift-off",
    "rail exit",
    "apogee (90%)",
    "charge",
    "duration",
    "lands",
    "checks",
    "flown: apogee, time",
)
WIDTHS = (0.075, 0.11, 0.12, 0.065, 0.07, 0.115, 0.065, 0.085, 0.085, 0.065, 0.145)
"""Column widths as fractions of the page's width. [1]"""
LANDSCAPE = (11.69, 8.27)
"""Width and height of a page. [inch]"""
ROWS = 12
"""Maximum number of flights on a page. [1]"""
LEGEND = (
    "90%, and in parentheses: from 5 to 95%. charge: seconds after (+) or before (-) apogee. lands: from the pad, "
    f"the median. checks: {MARKS['unsafe']} unsafe, {MARKS['caution']} caution, {MARKS['unknown']} not checked."
)
"""What the columns mean, below the notes."""
UNCHECKED_LABEL = f"{MARKS['unknown']} not checked, or to be checked by you: "
LINE, LINES = 165, 53
"""Length of the lines below the table [character], and the number of lines on a page without a table."""
TABLE_TOP, ROW_HEIGHT, LINE_HEIGHT, FOOT_OF_PAGE = 0.85, 0.034, 0.0155, 0.08
"""Top of the table, heights of its rows and of the lines below, and the bottom margin, as fractions of the page's
height. [1]"""


def day_sheet(title: str, site: Site, planned: Sequence[PlannedFlight], suffix: str, system: str = "SI") -> bytes:
    """The sheet as a picture, or as a PDF with as many pages as the plans need, in the units of a system.

    Raises BadValue for a picture with more flights than fit on a page.
    """
    kind, shown = suffix.lstrip("."), ShownUnits(system)
    if kind != "pdf" and len(planned) > ROWS:
        raise BadValue(f"found {len(planned)} flights, expected at most {ROWS} for a picture; a .pdf has pages")
    days = [_day(one.prediction.plan, shown) for one in planned]
    shared = [texts[0] if len(set(texts)) == 1 else "" for texts in zip(*days, strict=True)]
    own = [", ".join(text for text, same in zip(day, shared, strict=True) if not same) for day in days]
    heading = _heading(site, shared, shown)
    with styled():
        figures = []
        for first in range(0, len(planned), ROWS):
            part = planned[first : first + ROWS]
            rows, room = _plan_rows(part, own[first : first + ROWS], shown), _room(len(part))
            if kind != "pdf" and len(rows) > room:
                rows = [
                    *rows[: room - 1],
                    f"and {counted(len(rows) - room + 1, 'more line')}: a .pdf has room for them",
                ]
            figures.append(_page(title, heading, part, rows[:room], shown))
            more = range(room, len(rows), LINES)
            figures += [_more(title, rows[start : start + LINES]) for start in more]
        return bound(figures) if kind == "pdf" else drawn(figures[0], kind)


def _room(flights: int) -> int:
    """The number of lines that fit below a table of this number of flights."""
    return int((TABLE_TOP - _height(flights) - FOOT_OF_PAGE) / LINE_HEIGHT)


def _height(flights: int) -> float:
    """Height of the table as a fraction of the page's height. [1]"""
    return ROW_HEIGHT * (flights + 1)


def _page(title: str, heading: str, planned: Sequence[PlannedFlight], rows: Sequence[str], shown: ShownUnits) -> Figure:
    figure = Figure(figsize=LANDSCAPE)
    figure.text(0.03, 0.965, printable(title), fontsize=15, fontweight="bold", va="top")
    figure.text(0.03, 0.925, heading, fontsize=9, va="top")
    height = _height(len(planned))
    _table(figure.add_axes((0.03, TABLE_TOP - height, 0.94, height)), [_row(one, shown) for one in planned])
    _lines(figure, TABLE_TOP - height - 0.015, rows)
    return figure


def _more(title: str, rows: Sequence[str]) -> Figure:
    """A page with the lines that do not fit below the table."""
    figure = Figure(figsize=LANDSCAPE)
    figure.text(0.03, 0.965, f"{printable(title)}, continued", fontsize=15, fontweight="bold", va="top")
    _lines(figure, 0.92, rows)
    return figure


def _lines(figure: Figure, top: float, rows: Sequence[str]) -> None:
    figure.text(0.03, top, "\n".join(rows), fontsize=7.5, va="top", family="monospace")
    figure.text(0.03, 0.045, LEGEND, fontsize=8, va="bottom")
    figure.text(0.03, 0.02, ADVICE_NOTE, fontsize=9, fontweight="bold")


def _table(axes: Axes, rows: Sequence[Sequence[str]]) -> None:
    axes.set_axis_off()
    table = axes.table(
        cellText=[list(row) for row in rows],
        colLabels=list(HEADERS),
        colWidths=list(WIDTHS),
        cellLoc="left",
        bbox=Bbox.unit(),
    )
    table.auto_set_font_size(False)
    table.set_fontsize(8.5)
    for (row, _), cell in table.get_celld().items():
        cell.set_linewidth(0.6)
        cell.PAD = 0.03
        if row == 0:
            cell.set_text_props(fontweight="bold")
            cell.set_facecolor("0.9")


DAY = ("site", "wind", "temperature", "air")
"""What `_day` describes, in this order."""


def _day(plan: Flight, shown: ShownUnits) -> tuple[str, ...]:
    """Site and weather of a plan, in words."""
    return (
        plan.site or "site not named",
        "wind not given" if plan.wind is None else f"wind {profile_in_words(recorded_wind(plan), shown)}",
        f"temperature {'not given' if plan.temperature is None else shown.temperature(plan.temperature)}",
        f"air {air_of(plan).words(shown.system)}",
    )


def _heading(site: Site, shared: Sequence[str], shown: ShownUnits) -> str:
    """Site and weather of the day; empty entries of `shared` differ between its flights."""
    texts = [text or f"{name} differs, see each flight" for name, text in zip(DAY, shared, strict=True)]
    first = _site(site, shown) if shared[0] else texts[0]
    return "\n".join(fill(line, 150) for line in (first, "; ".join(texts[1:])))


def _site(site: Site, shown: ShownUnits) -> str:
    """A site with its known sizes, and the rules that govern it."""
    sizes = (("field", site.size), ("ceiling", site.ceiling), ("people", site.people), ("bystanders", site.bystanders))
    known = [f"{name} {shown.length(value)}" for name, value in sizes if value is not None]
    missing = [name for name, value in sizes if value is None]
    text = ", ".join([printable(site.name) or "site not named", *known, *(f"{name} not given" for name in missing)])
    return f"{text}; rules: {printable(site.rules) or 'NAR, FAA'}"


def _row(one: PlannedFlight, shown: ShownUnits) -> tuple[str, ...]:
    prediction, plan = one.prediction, one.prediction.plan
    low, middle, high = three_of_all(prediction.apogee)
    mass = None if plan.dry_mass is None else plan.dry_mass + prediction.found.motor.loaded_mass
    duration = None if prediction.stays_on_rail else three(one.down.duration)
    motor = plan.motor or prediction.found.motor.designation
    return (
        _both_ends(one.name, 10),
        shortened(f"{plan.rocket} {plan.config}".strip(), 17),
        shortened(motor, 19),
        "" if mass is None else shown.mass(mass),
        shown.speed(median(prediction.rail_speed) or 0.0),
        f"{shown.length(middle).split()[0]} ({shown.length(low).split()[0]}-{shown.length(high)})",
        _charge(prediction),
        "does not lift" if duration is None else f"{duration[1]:.0f} s ({duration[0]:.0f}-{duration[2]:.0f})",
        _lands(one, shown),
        _verdicts(one.lines),
        "",
    )


def _lands(one: PlannedFlight, shown: ShownUnits) -> str:
    """How far from the pad a flight lands, or why that is not known."""
    if one.prediction.stays_on_rail:
        return "none"
    return "no wind" if one.down.wind is None else f"{shown.length(three_of_all(one.down.away)[1])} away"


def _both_ends(text: str, most: int) -> str:
    """A name with at most this number of characters, without its middle: names of one day often differ at the end."""
    text, half = printable(text), most // 2
    return text if len(text) <= most else f"{text[: most - half - 1]}…{text[-half:]}"


def _charge(prediction: Prediction) -> str:
    """When the motor's charge fires after apogee; `altimeter` with dual deployment or a plugged motor, `unknown`
    without a delay, `none` if it does not fire in flight."""
    delay = prediction.plan.delay if prediction.plan.delay is not None else prediction.found.delay
    if prediction.plan.columns.recovery.dual or delay == PLUGGED_DELAY:
        return "altimeter"
    if delay is None:
        return "unknown"
    eject = prediction.median_eject if delay else None
    return "none" if eject is None else f"{round(eject, 1) + 0.0:+.1f} s"


def _verdicts(lines: Sequence[SafetyCheck]) -> str:
    """The numbers of checks that failed, have warnings, and are unknown: `2⊘ 1! 4?`."""
    worst_first: tuple[Verdict, ...] = ("unsafe", "caution", "unknown")
    counts = {verdict: sum(line.verdict == verdict for line in lines) for verdict in worst_first}
    return " ".join(f"{count}{MARKS[verdict]}" for verdict, count in counts.items() if count) or MARKS["ok"]


def _plan_rows(planned: Sequence[PlannedFlight], own: Sequence[str], shown: ShownUnits) -> list[str]:
    """The names of the checks that are unknown for every flight; then each flight's `own` site and weather if they
    differ, the recommended rail angle, its safety checks that did not pass, and the names of its own unknown ones."""
    unknown = [[line.name for line in one.lines if line.verdict == "unknown"] for one in planned]
    shared = [name for name in unknown[0] if len(planned) > 1 and all(name in names for names in unknown)]
    lines_below = [f"every flight  {UNCHECKED_LABEL}{', '.join(shared)}"] if shared else []
    for one, day, names in zip(planned, own, unknown, strict=True):
        rail = [rail_in_words(choice, shown) for choice in one.rail[:1]] or [f"none: {one.no_rail}"] * bool(one.no_rail)
        lines_below.append(f"{one.name}{f'  recommended rail: {rail[0]}' if rail else ''}")
        lines_below += [f"   {day}"] if day else []
        lines_below += [f"   {line.words(shown.system, source=False)}" for line in one.lines if line.failed]
        if rest := [name for name in names if name not in shared]:
            lines_below.append(f"   {UNCHECKED_LABEL}{', '.join(rest)}")
    return [row for text in lines_below for row in fill(printable(text), LINE, subsequent_indent="      ").splitlines()]
