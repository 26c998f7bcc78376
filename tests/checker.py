"""What checks the annotated types and shapes: an int may stand for a float, as type checkers have it."""

from collections.abc import Callable
from typing import TypeVar

from beartype import BeartypeConf, beartype

Checked = TypeVar("Checked", bound=Callable[..., object])

_CONFIGURED = beartype(conf=BeartypeConf(is_pep484_tower=True))


def check(function: Checked) -> Checked:
    """The same function, or class, which now complains of an argument or a result that is not as annotated."""
    checked: Checked = _CONFIGURED(function)
    return checked
