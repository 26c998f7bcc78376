"""The checker of annotated types and shapes; an int is accepted as a float, as in type checkers."""

from collections.abc import Callable
from typing import Any, TypeVar

from beartype import BeartypeConf, beartype

Checked = TypeVar("Checked", bound=Callable[..., object])

_CONFIGURED = beartype(conf=BeartypeConf(is_pep484_tower=True))
_CHECKED: dict[object, Any] = {}
"""Checked signatures by name and annotations."""


def check(function: Checked) -> Checked:
    """The function with checks of its arguments and results.

    jaxtyping passes a function without a body for each signature, and does so again at each definition of an inner
    function; beartype compiles equal ones only once.
    """
    code = function.__code__
    key = (
        function.__module__,
        function.__qualname__,
        code.co_varnames,
        code.co_flags,
        *function.__annotations__.items(),
    )
    if key not in _CHECKED:
        _CHECKED[key] = _CONFIGURED(function)
    checked: Checked = _CHECKED[key]
    return checked
