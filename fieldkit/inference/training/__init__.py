"""Training of the ensembles. Only this package imports torch, from the extra `fieldkit[train]`."""

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fieldkit.errors import FieldkitError
from fieldkit.inference.training.shipping import claim

EXTRA = ("torch", "onnx")
"""Packages that only training needs."""
RECIPES = ("paper",)


def trainer(recipe: str, out: Path) -> Callable[..., dict[str, Any]]:
    """The function that trains by a recipe into a folder.

    The folder is checked first, because importing torch takes seconds. Raises FieldkitError if the extra is not
    installed, for an unknown recipe, and if the folder cannot be used.
    """
    missing = [name for name in EXTRA if find_spec(name) is None]
    if missing:
        raise FieldkitError(f"training needs {' and '.join(missing)}: pip install 'fieldkit[train]'")
    if recipe not in RECIPES:
        raise FieldkitError(f"found the recipe {recipe!r}, expected one of: {', '.join(RECIPES)}")
    claim(out)
    from fieldkit.inference.training.paper import train_paper

    return train_paper
