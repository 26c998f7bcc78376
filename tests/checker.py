"""The checker of annotated types and shapes; an int is accepted as a float, as in type checkers."""

from collections.abc import Callable
from typing import TypeVar

from beartype import BeartypeConf, beartype

Checked = TypeVar("Checked", bound=Callable[..., object])

_CONFIGURED = beartype(conf=BeartypeConf(is_pep484_tower=True))


def check(function: Checked) -> Checked:
    """The function or class with checks of its arguments and results."""
    checked: Checked = _CONFIGURED(function)
    return checked
