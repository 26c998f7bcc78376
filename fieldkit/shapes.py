"""Array types that say their axes: `Float[Array, "draw time"]`, batch axes first, time last.

The checker and the tests (which set FIELDKIT_CHECK_SHAPES) read them through jaxtyping; an ordinary
run sees plain arrays and never imports it.
"""

import os
from typing import TYPE_CHECKING, Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

if TYPE_CHECKING or os.environ.get("FIELDKIT_CHECK_SHAPES"):
    from jaxtyping import Bool, Float, Int
else:

    class _Plain:
        """Stands for a jaxtyping type and forgets the axes."""

        def __class_getitem__(cls, item: tuple[Any, str]) -> Any:
            return item[0]

    Bool = Float = Int = _Plain

__all__ = ["Array", "Bool", "Flags", "Float", "Int", "Integers"]
