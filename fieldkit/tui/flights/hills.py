"""The drag and thrust inferred from one flight, as densities."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fieldkit.flight import Flight
from fieldkit.quantities import with_sd
from fieldkit.services.flight_facts import drag_facts
from fieldkit.tui.resources import Resources
from fieldkit.tui.widgets.plots import draw_density


@dataclass(frozen=True, slots=True)
class Hills:
    """The plots of drag and thrust: positions, headings and densities, with warnings."""

    drawn: tuple[tuple[str, str, Callable[[Any, Any], None]], ...]
    warnings: tuple[str, ...]


def hills(flight: Flight, resources: Resources) -> Hills:
    """The posterior of a flight for its plot. Raises FieldkitError if there is none."""
    drag = drag_facts(flight, resources.ledger, resources.motors, resources.settings.units)
    drawn = tuple(
        (
            place,
            f"{title}  {with_sd(values.mean(), values.std())}",
            draw_density(values, lambda value: f"{value:g}"),
        )
        for place, title, values in (("drag", drag.drag_name, drag.drag), ("thrust", "alpha", drag.thrust))
    )
    return Hills(drawn, drag.warnings)
