"""The first steps with an empty ledger: a rocket in four fields, the demo rocket, files, or a flight entered by
hand."""

from collections.abc import Sequence
from enum import Enum


class Step(Enum):
    """A first step: its name and what it does."""

    ROCKET = ("Describe your rocket", "four fields, then its first forecast")
    DEMO = ("Load the demo rocket", "twelve flights of Astra to explore")
    FILES = ("Import a file", "a log of your altimeter, or a table of flights")
    TYPE = ("Add a flight", "what the altimeter shows")


FIRST_STEPS = tuple(Step)


def step_cells(step: Step) -> Sequence[str]:
    """A row of the table."""
    name, about = step.value
    return (name, about)
