"""Array types that say their axes: `Float[Array, "draw time"]`, batch axes first, time last.

The checker and the tests (which set FIELDKIT_CHECK_SHAPES) read them through jaxtyping; an ordinary
run only writes them down, and imports neither jaxtyping nor numpy for it: a command that merely keeps
records should not wait for them.
"""

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING or os.environ.get("FIELDKIT_CHECK_SHAPES"):
    import numpy as np
    from jaxtyping import Bool, Float, Int

    if TYPE_CHECKING:
        Array = np.ndarray[Any, np.dtype[np.float64]]
    else:
        Array = np.ndarray[Any, np.dtype[np.float64]] | np.float64  # numpy hands out scalars for arrays of no axes
    Integers = np.ndarray[Any, np.dtype[np.int64]]
    Flags = np.ndarray[Any, np.dtype[np.bool_]]
else:

    class _Plain:
        """Stands for an array's type and ignores its annotation."""

        def __class_getitem__(cls, _: object) -> type:
            return cls

    Array = Integers = Flags = Bool = Float = Int = _Plain

__all__ = ["Array", "Bool", "Flags", "Float", "Int", "Integers"]
