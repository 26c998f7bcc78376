"""The first steps with an empty ledger: a rocket in four fields, the demo rocket, files, or a flight entered by
hand."""

from collections.abc import Sequence
from enum import Enum

from textual.content import Content


class Step(Enum):
    """A first step: its name and what it does."""

    ROCKET = ("Describe your rocket", "four fields, then its first forecast")
    DEMO = ("Load the demo rocket", "twelve flights of Astra to explore")
    FILES = ("Import a file", "a log of your altimeter, or a table of flights")
    TYPE = ("Add a flight", "what the altimeter shows")


FIRST_STEPS = tuple(Step)
LAUNCH_DAY = (
    ("p", "Plan", "rocket, mass and weather, entered once for the day"),
    ("f", "Fly", "every motor that fits, with its forecast; Enter saves one"),
    ("a", "Add", "what the altimeter shows; the plan is filled in already"),
    ("", "Compare", "forecast and flown apogee, the new Cd, the next forecast"),
    ("5", "Loop", "looks for the cause if forecasts miss"),
    ("^P", "Find", "anything by its name; ? explains the current page"),
)
"""The steps of a launch day: key, name, and what it shows."""


def launch_day() -> Content:
    """The steps of a launch day, one on a line."""
    lines = [Content.assemble(("A launch day", "b $primary"))]
    for key, name, about in LAUNCH_DAY:
        lines.append(Content.assemble((f"{key:2}", "b $accent"), (f"  {name:9}", "b"), about))
    return Content("\n").join(lines)


def step_cells(step: Step) -> Sequence[str]:
    """A row of the table."""
    name, about = step.value
    return (name, about)
