"""The card of the row under the cursor on the Setup page: facts and a picture.

A rocket from the side in solid cells, nose to the right, to scale if its dimensions are known.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil, sqrt
from typing import Any

from textual.containers import VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import Catalogue, Motor
from fieldkit.paths import data_file
from fieldkit.planning.air import air_of
from fieldkit.planning.check import MARKS
from fieldkit.planning.kits import Kit
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import Wanted
from fieldkit.planning.rule_lines import field_sizes
from fieldkit.planning.safety import thrust_check
from fieldkit.quantities import ShownUnits, density, measure, number, spelled, unit_of
from fieldkit.rocket import Configuration
from fieldkit.services.plausible_flights import motor_type
from fieldkit.tui.next import motor_facts
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.groups import Group, LaunchSite
from fieldkit.tui.widgets.hanging import Hanging, stacked
from fieldkit.tui.widgets.plots import EIGHTHS, draw_in, label_flights, round_ticks
from fieldkit.units import ZERO_CELSIUS

SKETCHED_FINENESS = 12.0
"""Assumed ratio of length to diameter if the length is unknown, typical of model rockets. [1]"""
NOSE_CALIBERS, FIN_CALIBERS, SPAN_CALIBERS = 3.0, 1.3, 0.9
"""Lengths of a sketched nose, fin root and fin span, in diameters. [1]"""
MIN_RADIUS = 1.0
"""Minimum half height of the drawn body. [cell width]"""
POINT = 0.5
"""Half height of the tip of the nose. [cell width]"""


@dataclass(frozen=True, slots=True)
class Shape:
    """A rocket from the side: half height of its body, lengths of nose and fins, and half heights of all from tail to
    tip; a cell is as high as two are wide. [cell width]"""

    radius: float
    nose: float
    fins: float
    heights: tuple[float, ...]


def shape(length: float | None, diameter: float, width: int) -> Shape:
    """A rocket with a length and a diameter [m], `width` cells long: body, elliptic nose, swept fins."""
    radius = max(MIN_RADIUS, width / (length / diameter if length else SKETCHED_FINENESS) / 2)
    nose, fins = min(2 * NOSE_CALIBERS * radius, width / 2), min(2 * FIN_CALIBERS * radius, width / 3)
    heights = []
    for x in range(width):
        from_tip, fin = (width - x - 0.5) / nose, 1 - (x + 0.5) / fins
        body = radius * sqrt(1 - max(0.0, 1 - from_tip) ** 2)
        heights.append(max(body, POINT, radius + 2 * SPAN_CALIBERS * radius * fin**0.7 if fin > 0 else 0.0))
    return Shape(radius, nose, fins, tuple(heights))


def drawing(length: float | None, diameter: float, width: int) -> list[Content]:
    """The lines of a drawing of a rocket with a length and a diameter [m], `width` cells wide, its edges in eighths of
    a cell, nose and fins in another color than the body."""
    rocket = shape(length, diameter, width)
    rows = ceil(max(rocket.heights) / 2)
    above, below = [], []
    for row in range(rows):
        upper, lower = [], []
        for x, height in enumerate(rocket.heights):
            level = max(0, min(8, round(4 * height) - 8 * row))
            fin = x < rocket.fins and 2 * row + 1 > rocket.radius
            ink = "$accent" if fin or x >= width - rocket.nose else "$primary"
            upper.append((EIGHTHS[level % 8], f"{ink} reverse" if level == 8 else ink))
            lower.append((EIGHTHS[-level % 8], f"{ink} reverse" if level else ink))
        above.append(Content.assemble(*upper))
        below.append(Content.assemble(*lower))
    return [*reversed(above), *below]


def draw_rocket(diameter: float, _: Any, ink: Any) -> Content:
    """A rocket with a diameter [m] from the side, a sketch as large as a plot has room for, in its middle."""
    rows = len(drawing(None, diameter, DRAWING_WIDTH))
    width = min(ink.width, DRAWING_WIDTH * ink.height // rows)
    lines = drawing(None, diameter, width)
    lines = [Content(" " * ((ink.width - width) // 2)) + line for line in lines]
    return Content("\n").join([Content()] * ((ink.height - len(lines)) // 2) + lines)


def centers(cg: float, cp: float, width: int) -> str:
    """A line below a drawing with marks at the centers of gravity and of pressure, at fractions of the length from the
    tip [1]: `CP ▲    ▲ CG`."""
    places = sorted((round((1 - at) * (width - 1)), name) for at, name in ((cg, "CG"), (cp, "CP")))
    (left, behind), (right, ahead) = places
    between = "▲ " if left == right else "▲" + " " * (right - left - 1) + "▲ "
    return f"{f'{behind} ':>{left}}{between}{ahead}"


def caption(length: float | None) -> str:
    """The note below a drawing that is not to scale; empty if the length [m] is known."""
    return "" if length else "a sketch: import its .ork file for its length"


DRAWING_WIDTH = 56
"""Width of the drawn rocket: that of the narrowest card. [cell]"""
MIN_MARGIN = 1.0
"""Stability margin below which a design is marked: the CG belongs at least one diameter ahead of the CP (G. H. Stine,
Handbook of Model Rocketry). [caliber]"""
SHOWN_TEMPERATURES = tuple(ZERO_CELSIUS + celsius for celsius in (0, 10, 20, 30, 40))
"""Temperatures at which the air of a site is shown. [K]"""
SIZE_TOLERANCE = 0.01
"""Largest rounding of the size of a field in feet. [m]"""
MAX_DRAWN_FLIGHTS = 120
"""Number of latest flights to draw, more than the card has columns."""


@dataclass(frozen=True, slots=True)
class Facts:
    """The facts of a card, and its picture with a title, None for no picture; `below` are facts below the picture."""

    blocks: tuple[Hanging, ...]
    title: str = ""
    draw: Any = None
    below: tuple[Hanging, ...] = ()


class SetupCard(VerticalScroll):
    """Facts, below them a plot, added when there is something to draw, and further facts."""

    DEFAULT_CSS = """
    SetupCard { padding: 0 1; }
    SetupCard Static { height: auto; }
    SetupCard #below { margin-top: 1; }
    SetupCard Plot { height: 1fr; min-height: 14; max-height: 30; margin-top: 1; border-top: solid $border-blurred;
        border-title-color: $foreground; }
    """

    def compose(self) -> Iterable[Widget]:
        """The facts; the plot is added between them."""
        yield Static(id="facts")
        yield Static(id="below")

    def show(self, facts: Facts) -> None:
        """Show the whole card, with its picture if there is room."""
        self.query_one("#facts", Static).update(stacked(facts.blocks))
        draw_in(self, facts.draw, facts.title)
        self.set_class(facts.draw is not None, "-drawn")
        below = self.query_one("#below", Static)
        below.update(stacked(facts.below))
        below.display = bool(facts.below)
        if self.children[-1] is not below:  # the plot was added now
            self.move_child(below, after=-1)


def of_motor(motor: Motor, system: str) -> Facts:
    """A motor and its thrust curve, with masses in the units of a system."""
    content = cards.lines(f"{motor.maker} {motor.designation}", motor_facts.facts(motor, system))
    return Facts((content,), motor_facts.THRUST, partial(motor_facts.draw_thrust, motor))


def of_build(group: Group, system: str, design: Configuration | None, motors: Catalogue) -> Facts:
    """A configuration of a rocket, with its design if known: drawing, mass, stability, motors by type, apogees. The
    drawing is first, since a low strip shows nothing else."""
    flights, length = group.flights, design.length if design is not None else None
    pairs = [
        ("flights", _used(flights)),
        *_dates(flights),
        ("dry mass", measure(cards.DRY_MASS, group.last.dry_mass, system) or "not known: Enter to set it"),
        ("diameter", measure(cards.DIAMETER, group.last.diameter, system) or "not known: Enter to set it"),
        ("length", measure(cards.DIAMETER, length, system)),
        ("stability", _stability(design) if design is not None else ""),
    ]
    flew_on: dict[str, list[Flight]] = defaultdict(list)
    for one in flights:
        flew_on[motor_type(one.motor, motors) if one.motor else "no motor named"].append(one)
    flown = cards.lines("Motors it flew on", [(name, _heights(some, system)) for name, some in flew_on.items()])
    known = [one for one in flights if one.apogee is not None][-MAX_DRAWN_FLIGHTS:]
    draw = partial(draw_apogees, known, None, system) if len(known) > 1 else None
    drawn = (_side_view(group.last.diameter, design),) if group.last.diameter else ()
    return Facts((*drawn, cards.lines(" ".join(group.names), pairs), flown), apogees_title(system), draw)


def _used(flights: Sequence[Flight]) -> str:
    """How many flights there are, and how many of them have no anomaly."""
    clean = sum(one.clean for one in flights)
    return f"{len(flights)}, {'all' if clean == len(flights) else f'{clean} of them'} normal"


def _stability(design: Configuration) -> str:
    """The stability margin of a design, marked if it is low."""
    if design.margin is None:
        return ""
    low = f" {MARKS['unsafe']} below {MIN_MARGIN:g}" if design.margin < MIN_MARGIN else ""
    return f"{design.margin:.1f} calibers off the rod, as simulated{low}"


def _side_view(diameter: float, design: Configuration | None) -> Hanging:
    """The rocket from the side with its centers of gravity and of pressure, and which parts are sketched."""
    length = design.length if design is not None else None
    below = [caption(length)]
    if design is not None and length and design.cg is not None and design.cp is not None:
        below.insert(0, centers(design.cg / length, design.cp / length, DRAWING_WIDTH))
    lines = drawing(length, diameter, DRAWING_WIDTH) + [Content(line) for line in below if line]
    return Hanging(tuple((0, line) for line in lines))


def of_site(place: LaunchSite, rules: str, system: str) -> Facts:
    """A site: its air, its flights, and the limits for its safety checks; `rules` are the authorities of sites without
    their own."""
    site, flights = place.site, place.flights
    rockets = sorted({one.rocket for one in flights if one.rocket})
    pairs = [
        ("flights", f"{len(flights)}" + (f", of {', '.join(rockets)}" if rockets else "")),
        *_dates(flights),
        ("highest", _highest(flights, system)),
        ("elevation", measure(cards.ELEVATION, site.elevation, system) or "not known: sea level; Enter to set it"),
        ("air", f"{density(air_of(Flight(site_elevation=site.elevation)).density, system)} on a standard day"),
        ("field size", measure(cards.APOGEE, site.size, system) or "not known; needed for a safety check"),
        ("ceiling", measure(cards.APOGEE, site.ceiling, system) or "not known; needed for a safety check"),
    ]
    known = [one for one in flights if one.apogee is not None][-MAX_DRAWN_FLIGHTS:]
    draw = partial(draw_apogees, known, site.ceiling, system) if len(known) > 1 else None
    title = apogees_title(system) + (", ─ the ceiling" if site.ceiling else "")
    by_rocket: dict[str, list[Flight]] = defaultdict(list)
    for one in flights:
        by_rocket[one.rocket].append(one)
    flown = [(name, _heights(some, system)) for name, some in by_rocket.items() if name]
    here = (cards.lines("Flown here", flown),) if flown else ()
    return Facts((cards.lines(site.name, pairs),), title, draw, (*here, *for_sites(site, rules, system)))


def for_sites(site: Site, rules: str, system: str) -> tuple[Hanging, Hanging]:
    """The fields that the code requires for each class of motors, beside the size of a site, and its air in other
    weather; `rules` are the authorities of sites without their own. Raises BadValue for a damaged file of rules."""
    shown, sizes = ShownUnits(system), field_sizes(site.rules or rules)
    fields = [(one.classes, _with_verdict(one.least, site.size, shown)) for one in sizes]
    code = f"Field for model rockets by {sizes[0].code}" if sizes else ""
    airs = []
    for kelvin in SHOWN_TEMPERATURES:
        air = air_of(Flight(site_elevation=site.elevation, temperature=kelvin))
        airs.append((shown.temperature(kelvin), f"{density(air.density, system)}, {air.altimeter}"))
    return cards.lines(code, fields), cards.lines("Air there, by the temperature", airs)


def _with_verdict(least: float, size: float | None, shown: ShownUnits) -> str:
    """The shorter side that a code requires [m], and whether a field of this size has it."""
    verdict = "" if size is None else f" {MARKS['ok' if size >= least - SIZE_TOLERANCE else 'unsafe']}"
    return f"{shown.length(least)}{verdict}"


def of_kit(kit: Kit, system: str, builds: Sequence[Group], motors: Catalogue) -> Facts:
    """A kit, with its drawing if its diameter is known, the rockets named after it, and the motors that fit it."""
    unknown = "not known: Enter to set it"
    pairs = [
        ("dry mass", measure(cards.DRY_MASS, kit.dry_mass, system) or unknown),
        ("diameter", measure(cards.DIAMETER, kit.diameter, system) or unknown),
        ("mount", unknown if kit.mount is None else f"motors up to {kit.mount * 1e3:g} mm"),
    ]
    use = Hanging(((0, Content("Name a rocket after the kit, on Home or with p on Fly: it starts with these.")),))
    named = [one for one in builds if one.names[0].casefold() == kit.name.casefold()]
    rockets = [(" ".join(one.names).strip(), _heights(one.flights, system)) for one in named]
    blocks = [cards.lines("Rockets named after it", rockets)] if rockets else [use]
    fitting = cards.lines("Motors that fit it", motors_of_kit(kit, motors))
    draw = partial(draw_rocket, kit.diameter) if kit.diameter else None
    return Facts((cards.lines(kit.name, pairs), *blocks, fitting), caption(None), draw)


def motors_of_kit(kit: Kit, motors: Catalogue) -> list[tuple[str, str]]:
    """The motors in production that fill the mount of a kit, by class, without those that are too weak for its mass;
    none without a mount."""
    if kit.mount is None:
        return []
    known, wanted = limits(data_file("limits.toml")), Wanted(mount=kit.mount, dry_mass=kit.dry_mass)
    named: dict[str, dict[str, None]] = defaultdict(dict)
    for motor in filter(wanted.fits, motors.search("")):
        weak = kit.dry_mass is not None and thrust_check(motor, kit.dry_mass, known).verdict != "ok"
        named[motor.impulse_class][f"{motor.designation}{' !' * weak}"] = None
    note = f"thrust to weight below {known['thrust_to_weight'].value:g}"
    any_weak = any(one.endswith("!") for own in named.values() for one in own)
    return [*((name, ", ".join(own)) for name, own in sorted(named.items())), *([("!", note)] if any_weak else [])]


def _dates(flights: Sequence[Flight]) -> Iterable[tuple[str, str]]:
    """The first day and the last, or the only one."""
    days = [f"{one.date_time:%Y-%m-%d}" for one in flights if one.date_time is not None]
    if days:
        yield "flown", days[0] if days[0] == days[-1] else f"{days[0]} to {days[-1]}"


def _heights(flights: Sequence[Flight], system: str) -> str:
    """The number of flights and their apogees: `3 times, to between 200.1 and 281.3 m`."""
    times = "once" if len(flights) == 1 else f"{len(flights)} times"
    heights = [one.apogee for one in flights if one.apogee is not None]
    if not heights:
        return times
    low, high = (number(cards.APOGEE, end, system) for end in (min(heights), max(heights)))
    unit = spelled(unit_of(cards.APOGEE, system))
    return f"{times}, to {high} {unit}" if low == high else f"{times}, to between {low} and {high} {unit}"


def _highest(flights: Sequence[Flight], system: str) -> str:
    """The highest apogee, with its rocket and motor."""
    best = max(flights, key=lambda one: one.apogee or 0.0, default=None)
    if best is None or best.apogee is None:
        return ""
    return " ".join(part for part in (measure(cards.APOGEE, best.apogee, system), best.rocket, best.motor) if part)


def apogees_title(system: str) -> str:
    """The title of drawn apogees, with their unit."""
    return f"apogee [{spelled(unit_of(cards.APOGEE, system))}], flight by flight; ✗ tagged"


def draw_apogees(flights: Sequence[Flight], ceiling: float | None, system: str, plt: Any, ink: Any) -> None:
    """Draw the apogees in order, and the ceiling, with round heights beside them and the ids below."""
    heights = [float(number(cards.APOGEE, one.apogee or 0.0, system)) for one in flights]
    for clean, marker, colour in ((True, "●", ink.line), (False, "✗", ink.mark)):
        places = [place for place, one in enumerate(flights) if one.clean is clean]
        if places:
            plt.scatter(places, [heights[place] for place in places], marker=marker, color=colour)
    if ceiling is not None:
        plt.hline(float(number(cards.APOGEE, ceiling, system)), color=ink.mark)
    label_flights(plt, ink, [one.flight_id for one in flights])
    drawn = [*heights, *([float(number(cards.APOGEE, ceiling, system))] if ceiling is not None else [])]
    low, high = min(drawn), max(drawn)
    margin = 0.08 * (high - low) or 1.0
    plt.ylim(low - margin, high + margin)
    ticks = round_ticks(low - margin, high + margin, max(2, ink.height // 3))
    plt.yticks(ticks, [f"{tick:g}" for tick in ticks])
