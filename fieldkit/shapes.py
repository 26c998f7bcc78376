"""Array types with named axes: `Float[Array, "draw time"]`, batch axes first, time last.

The checker and the tests (which set FIELDKIT_CHECK_SHAPES) read them through jaxtyping; an ordinary run ignores them
and imports neither jaxtyping nor numpy for them, because commands without computations should start fast.
"""

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING or os.environ.get("FIELDKIT_CHECK_SHAPES"):
    import numpy as np
    from jaxtyping import Bool, Float, Int

    if TYPE_CHECKING:
        Array = np.ndarray[Any, np.dtype[np.float64]]
    else:
        Array = np.ndarray[Any, np.dtype[np.float64]] | np.float64  # numpy returns scalars for arrays without axes
    Integers = np.ndarray[Any, np.dtype[np.int64]]
    Flags = np.ndarray[Any, np.dtype[np.bool_]]
else:

    class _Plain:
        """A stand-in for an array type that ignores its annotation."""

        def __class_getitem__(cls, _: object) -> type:
            return cls

    Array = Integers = Flags = Bool = Float = Int = _Plain

__all__ = ["Array", "Bool", "Flags", "Float", "Int", "Integers"]
