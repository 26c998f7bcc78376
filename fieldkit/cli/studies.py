"""The studies, which are in a checkout but not in the wheel: whether they are installed, and how to install them."""

from importlib.util import find_spec

from fieldkit.errors import FieldkitError

HOW_TO_INSTALL = "from a checkout of fieldkit: pip install -e ."
"""How to install the studies."""


def studies_are_here() -> bool:
    """Whether the studies can be imported."""
    try:
        return find_spec("studies.paper") is not None
    except ModuleNotFoundError:
        return False


def need_studies() -> None:
    """Raise FieldkitError that says what to install if the studies are missing."""
    if not studies_are_here():
        raise FieldkitError(f"the studies are not in the installed program; {HOW_TO_INSTALL}")
