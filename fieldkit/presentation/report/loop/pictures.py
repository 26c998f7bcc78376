"""The pictures of the loop's report. Each draws into given axes; none opens a window."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.flight import BY_NAME
from fieldkit.model.readout_data import Data
from fieldkit.physics.effect import effect_named
from fieldkit.presentation.condition_axis import in_units
from fieldkit.presentation.report.style import (
    AFTER_COLOR,
    BEFORE_COLOR,
    FAINT_COLOR,
    INK_COLOR,
    drawn,
    shortened,
    styled,
)
from fieldkit.quantities import ShownUnits
from fieldkit.scoring.score import Forecasts
from fieldkit.selection.drag_steps import FlightDrag
from fieldkit.selection.fingerprint import FingerprintMark
from fieldkit.selection.logged_forces import ThrustProfile
from fieldkit.selection.residual import columns_of
from fieldkit.selection.verdict import NAMING_PROBABILITY
from fieldkit.services.findings import Findings
from fieldkit.shapes import Array, Float

TITLES = {"flight_number": "flight, in the order flown", "hour": "hour of the day"}

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

NINE_OF_TEN = 1.645
"""Half width of the central 90% interval of a normal distribution, in standard deviations. [1]"""
DrawFindings = Callable[["Figure | SubFigure", Findings, ShownUnits], None]


@dataclass(frozen=True, slots=True)
class Axis:
    """A title, a value for each flight (nan if not recorded), and the names of the values if they are groups."""

    title: str
    values: Float[Array, "flight"]
    names: Sequence[str] = ()


def axis(found: Findings, system: str = "SI") -> Axis:
    """The column of the accepted effect, or else of the strongest correlation, or else the order flown; in the units of
    a system.
    """
    diagnosis = found.diagnosis
    for trial in diagnosis.accepted[:1]:
        effect = effect_named(trial.candidate.place.effect)
        if effect.needs:
            column = BY_NAME[effect.needs]
            return Axis(*in_units(column.header, diagnosis.model.recorded(column.name), system))
        if trial.candidate.place.where and not trial.candidate.place.since:
            return _grouped(found, effect.per)
        if effect.grows or trial.candidate.place.since:
            return _numbered(found, "flight_number", system)
    if found.patterns and (diagnosis.accepted or found.patterns[0].p < 0.1):
        best = found.patterns[0].against
        return _numbered(found, best, system) if best in columns_of(diagnosis) else _grouped(found, best)
    return _numbered(found, "flight_number", system)


def _numbered(found: Findings, name: str, system: str) -> Axis:
    title, values = in_units(name, columns_of(found.diagnosis)[name], system)
    return Axis(TITLES.get(name, title), values)


def _grouped(found: Findings, per: str) -> Axis:
    model = found.diagnosis.model
    own = model.groups(per)
    names = list(dict.fromkeys(own))
    return Axis(per, np.array([names.index(name) for name in own], float), names)


def residuals(figure: "Figure | SubFigure", found: Findings, shown: ShownUnits) -> None:
    """Leave-one-out errors, flown minus forecast, before and after, against the column of the verdict."""
    diagnosis, against = found.diagnosis, axis(found, shown.system)
    sides = [("before", diagnosis.forecasts_before, BEFORE_COLOR)]
    if diagnosis.effect != "none":
        sides.append(("after: " + diagnosis.effect, diagnosis.forecasts_after, AFTER_COLOR))
    panels = figure.subplots(1, len(sides), sharey=True, squeeze=False)[0]
    for panel, (title, forecasts, colour) in zip(panels, sides, strict=True):
        _residual_panel(panel, against, forecasts, diagnosis.data, colour, shown.length_factor)
        panel.set_title(title)
    panels[0].set_ylabel(f"flown - forecast [{shown.length_unit}]")


def _residual_panel(panel: "Axes", against: Axis, forecasts: Forecasts, data: Data, colour: str, unit: float) -> None:
    """Draw residuals of one model, in multiples of `unit` [m]."""
    known = data.seen[:, 0] & np.isfinite(against.values)
    place = against.values[known] + _beside(against.values[known], 0.6 if against.names else 0.012)
    low, high = _interval(forecasts)
    apogee = forecasts.apogee
    miss = (np.exp(data.values[:, 0]) - apogee)[known] / unit
    panel.axhline(0, color=INK_COLOR, linewidth=1)
    panel.vlines(
        place, (low - apogee)[known] / unit, (high - apogee)[known] / unit, color=colour, alpha=0.25, linewidth=3
    )
    panel.plot(place, miss, "o", color=colour, markersize=5)
    panel.set_xlabel(against.title)
    if against.names:
        panel.set_xticks(range(len(against.names)), [shortened(name) for name in against.names])
        panel.set_xlim(-0.6, len(against.names) - 0.4)


def _beside(values: Float[Array, "shown"], width: float) -> Float[Array, "shown"]:
    """Horizontal offsets for flights with the same position, so that each is visible."""
    width = width if width > 0.1 else 6 * width * max(float(np.ptp(values)), 1e-9)
    step = np.zeros(len(values))
    for value in np.unique(values):
        rows = np.flatnonzero(values == value)
        step[rows] = width * (np.arange(len(rows)) - (len(rows) - 1) / 2) / max(len(rows) - 1, 4)
    return step


def _interval(forecasts: Forecasts) -> tuple[Float[Array, "flight"], Float[Array, "flight"]]:
    """Ends of the 90% interval of each forecast, with its mixture approximated by one log-normal distribution. [m]"""
    mean = (forecasts.weight * forecasts.mean).sum(axis=0)
    sd = np.sqrt((forecasts.weight * (forecasts.sd**2 + (forecasts.mean - mean) ** 2)).sum(axis=0))
    return np.exp(mean - NINE_OF_TEN * sd), np.exp(mean + NINE_OF_TEN * sd)


def forward(figure: "Figure | SubFigure", found: Findings, shown: ShownUnits) -> None:
    """Draw the forecast of each flight from the earlier ones, with its flown apogee."""
    panel, ahead = figure.subplots(), found.ahead
    number = np.arange(len(ahead.seen)) + 1
    unit = shown.length_factor
    flown = np.exp(found.diagnosis.data.values[:, 0]) / unit
    sides = [("no correction", ahead.before, BEFORE_COLOR, -0.14)]
    if any(ahead.chosen):
        sides.append(("effects chosen from earlier flights", ahead.after, AFTER_COLOR, 0.14))
    for title, forecasts, colour, shift in sides:
        low, high = (ends[ahead.seen] / unit for ends in _interval(forecasts))
        place = number[ahead.seen] + shift
        panel.vlines(place, low, high, color=colour, alpha=0.3, linewidth=5)
        panel.plot(place, forecasts.apogee[ahead.seen] / unit, "_", color=colour, markersize=8, mew=2, label=title)
    used_in_fit = found.diagnosis.data.seen[:, 0]
    panel.plot(number[used_in_fit], flown[used_in_fit], "o", color=INK_COLOR, markersize=4, label="flown")
    panel.set_xlabel("flight, in the order flown")
    panel.set_ylabel(f"apogee [{shown.length_unit}]")
    panel.margins(y=0.2)
    panel.legend(loc="best", ncols=3, fontsize=8)
    panel.locator_params(axis="x", integer=True)


def fingerprints(figure: "Figure | SubFigure", found: Findings, _: ShownUnits) -> None:
    """Draw the fingerprints of the most likely effects in the readouts, and the observed residuals."""
    count = len(found.fingerprints)
    if not count:
        return
    panels = figure.subplots(1, count, sharey=True, sharex=True, squeeze=False)[0]
    for panel, (trial, row) in zip(panels, found.fingerprints, strict=True):
        _fingerprint(panel, row)
        panel.set_title(shortened(str(trial.candidate.place), 30))
    titles = [BY_NAME[mark.readout].title.lower() for mark in found.fingerprints[0][1]]
    panels[0].set_yticks(range(len(titles)), titles)
    panels[0].invert_yaxis()
    reach = max(abs(end) for panel in panels for end in panel.dataLim.intervalx)
    panels[0].set_xlim(-1.1 * reach, 1.1 * reach)
    panels[len(panels) // 2].set_xlabel("shift / expected scatter of the readout")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=2, fontsize=8)


def _fingerprint(panel: "Axes", row: tuple[FingerprintMark, ...]) -> None:
    place = np.arange(len(row))
    expected, found, sd = (np.array([getattr(mark, name) for mark in row]) for name in ("expected", "found", "sd"))
    panel.axvline(0, color=INK_COLOR, linewidth=1)
    panel.barh(
        place, np.nan_to_num(expected), height=0.62, color=AFTER_COLOR, alpha=0.35, label="predicted by the effect"
    )
    known = np.isfinite(found)
    panel.errorbar(
        found[known], place[known], xerr=NINE_OF_TEN * sd[known], fmt="o", color=INK_COLOR, markersize=4, linewidth=1,
        label="observed in the flights",
    )  # fmt: skip
    for number in place[~known]:
        note = panel.annotate(
            "not recorded", (1, number), (-4, 0), xycoords=("axes fraction", "data"), textcoords="offset points",
            va="center", ha="right", fontsize=7, color=FAINT_COLOR,
        )  # fmt: skip
        note.set_in_layout(False)
    panel.grid(axis="y", visible=False)


def ladder(figure: "Figure | SubFigure", found: Findings, _: ShownUnits) -> None:
    """Draw the probability of each effect, and the threshold for naming one."""
    panel = figure.subplots()
    items = [item for item in found.diagnosis.ranking if item.effect]
    chance = np.array([item.probability for item in items])
    accepted = [item.effect in found.diagnosis.effect.split("+") for item in items]
    colours = [AFTER_COLOR if one else FAINT_COLOR for one in accepted]
    rows = range(len(items))
    panel.barh(rows, chance, height=0.6, color=colours, alpha=0.6)
    panel.axvline(NAMING_PROBABILITY, color=BEFORE_COLOR, linewidth=1.2, linestyle=(0, (4, 2)))
    panel.text(NAMING_PROBABILITY, -0.9, " named above this", fontsize=7.5, color=BEFORE_COLOR, va="bottom")
    for row, value in enumerate(chance):
        panel.text(value + 0.01, row, f"{value:.0%}", va="center", fontsize=8, color=FAINT_COLOR)
    panel.set_yticks(rows, [shortened(str(item.best.candidate.place), 34) for item in items])
    panel.invert_yaxis()
    panel.margins(x=0.12)
    panel.set_xlim(0, 1.12)
    panel.set_xlabel("inclusion probability")
    panel.grid(axis="y", visible=False)


def forces(figure: "Figure | SubFigure", found: Findings, _: ShownUnits) -> None:
    """Draw drag along the coast and thrust along the burn of each log, relative to the rocket's own drag and the
    certified thrust, with 90% bands."""
    assert found.diagnosis.forces is not None
    panels = figure.subplots(1, 2)
    drag = found.diagnosis.forces.drag
    sides: tuple[Mapping[str, FlightDrag | ThrustProfile], ...] = (drag, found.diagnosis.forces.thrust)
    titles = ("drag / the rocket's own", "thrust / certified")
    for panel, title, along in zip(panels, titles, sides, strict=True):
        for name, one in along.items():
            steps = drag[name].steps
            colour = BEFORE_COLOR if any(step.probability > 0.5 for step in steps) else AFTER_COLOR
            low, high = one.ratio - NINE_OF_TEN * one.sd, one.ratio + NINE_OF_TEN * one.sd
            panel.fill_between(one.time_from_liftoff, low, high, color=colour, alpha=0.12, linewidth=0)
            panel.plot(one.time_from_liftoff, one.ratio, color=colour, linewidth=1.0)
        panel.axhline(1, color=INK_COLOR, linewidth=1)
        panel.set_xlabel("time from lift-off [s]")
        panel.set_ylabel(title)
        panel.set_ylim(0, max(2.0, *(1.1 * float(one.ratio.max()) for one in along.values())) if along else 2.0)


PICTURES: Mapping[str, tuple[DrawFindings, tuple[float, float]]] = {
    "residuals": (residuals, (7.6, 3.0)),
    "forward": (forward, (7.6, 2.9)),
    "fingerprints": (fingerprints, (7.6, 3.6)),
    "ladder": (ladder, (7.6, 3.7)),
    "forces": (forces, (7.6, 2.9)),
}
"""Each picture and its size. [inch]"""


def pictures(found: Findings) -> list[str]:
    """Names of the pictures with any content."""
    measured = found.diagnosis.forces
    return [name for name in PICTURES if name != "forces" or (measured is not None and measured.drag)]


def svg(name: str, found: Findings, system: str = "SI") -> bytes:
    """One picture as an SVG document, letters drawn as shapes."""
    from matplotlib.figure import Figure  # takes 0.3 s to import

    draw, size = PICTURES[name]
    with styled():
        figure = Figure(figsize=size, layout="constrained")
        draw(figure, found, ShownUnits(system))
        return drawn(figure, "svg")


def png(found: Findings, system: str = "SI") -> bytes:
    """All pictures below each other, as one PNG, in the units of a system."""
    from matplotlib.figure import Figure  # takes 0.3 s to import

    with styled():
        chosen = [PICTURES[name] for name in pictures(found)]
        sizes = [size for _, size in chosen]
        figure = Figure(figsize=(sizes[0][0], sum(high for _, high in sizes) + 0.5), layout="constrained")
        figure.suptitle(f"{found.rocket}: {found.diagnosis.effect}", fontsize=13, weight="bold", x=0.02, ha="left")
        parts = figure.subfigures(len(sizes), 1, height_ratios=[high for _, high in sizes], squeeze=False)
        for part, (draw, _) in zip(parts[:, 0], chosen, strict=True):
            draw(part, found, ShownUnits(system))
        return drawn(figure, "png")
