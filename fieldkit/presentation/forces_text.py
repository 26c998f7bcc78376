"""What the logs of flights show of drag and thrust, in a few sentences."""

from collections.abc import Iterator

from fieldkit.flight.short_name import flight_label
from fieldkit.quantities import counted, with_sd
from fieldkit.selection.drag_steps import DragStep
from fieldkit.selection.logged_forces import LoggedForces


def forces_in_words(forces: LoggedForces | None) -> Iterator[str]:
    """Which flights' drag switched, when and by how much; empty if no flight has a log."""
    if forces is None:
        return
    if forces.drag:
        yield f"drag along the coast, {counted(len(forces.drag), 'log')}: {_switched(forces)}"
    reasons: dict[str, list[str]] = {}
    for flight_id, why in forces.silent.items():
        reasons.setdefault(why, []).append(flight_id)
    for why, ids in reasons.items():
        others = f" and {len(ids) - 1} more" if len(ids) > 1 else ""
        yield f"{counted(len(ids), 'log')} without forces, {ids[0]}{others}: {why}"


def _switched(forces: LoggedForces) -> str:
    likely = {name: [step for step in one.steps if step.probability > 0.5] for name, one in forces.drag.items()}
    named = [f"{flight_label(name)} {', '.join(map(_step, steps))}" for name, steps in likely.items() if steps]
    return "it switches in " + "; ".join(named) if named else "constant within the errors"


def _step(step: DragStep) -> str:
    until = "on" if step.end is None else f"to {step.end:.1f} s"
    return f"from {step.begin:.1f} s {until} (times {with_sd(step.ratio, step.sd)})"
