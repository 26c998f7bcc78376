"""Making the ensembles that the field runs. The only home of torch; the extra `fieldkit[train]`."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

from fieldkit.errors import FieldkitError

EXTRA = ("torch", "onnx")
"""What only training needs."""


def trainer(recipe: str) -> Callable[..., dict[str, Any]]:
    """The function that trains by a recipe. Raises FieldkitError if the extra is not installed."""
    missing = [name for name in EXTRA if find_spec(name) is None]
    if missing:
        raise FieldkitError(f"training needs {' and '.join(missing)}: pip install 'fieldkit[train]'")
    if recipe == "field":
        from fieldkit.inference.training.field import train_field

        return train_field
    if recipe == "history":
        from fieldkit.inference.training.history import train_history

        return train_history
    if recipe != "paper":
        raise FieldkitError(f"found the recipe {recipe!r}, expected paper, field or history")
    from fieldkit.inference.training.paper import train_paper

    return train_paper
