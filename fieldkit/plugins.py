"""Finding plug-ins: every module in a plug-in folder that binds one upper-case name.

The plug-in folders have no `__init__.py`. They are next to `fieldkit/` in a checkout and inside it in an installed
wheel; in both cases they are mounted as `fieldkit.parsers` and `fieldkit.models`, so another package named `models` is
never imported instead.
"""

import json
import sys
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec
from pathlib import Path
from pkgutil import iter_modules
from types import MappingProxyType

from fieldkit.errors import DamagedModel

PLUGIN_FOLDERS = ("parsers", "models")


def plugin_folder(group: str) -> Path:
    """A plug-in folder, which may be missing: inside the package, or else next to it."""
    package = Path(__file__).parent
    inside = package / group
    return inside if inside.is_dir() else package.parent / group


def mount() -> None:
    """Make the plug-in folders importable below `fieldkit`, without importing anything from them."""
    for group in PLUGIN_FOLDERS:
        folder = plugin_folder(group)
        name = f"fieldkit.{group}"
        if folder.parent == Path(__file__).parent or not folder.is_dir() or name in sys.modules:
            continue
        spec = ModuleSpec(name, None, is_package=True)
        spec.submodule_search_locations = [str(folder)]
        module = module_from_spec(spec)
        sys.modules[name] = module
        setattr(sys.modules["fieldkit"], group, module)


@cache
def plugins(group: str, attribute: str) -> Mapping[str, object]:
    """The values of `attribute` in the modules of a plug-in folder, by module name in alphabetical order.

    `plugins("parsers", "PARSER")`, `plugins("models.effects", "EFFECT")`. Modules whose name starts with an underscore
    are helpers and are left out. A module without the attribute is a programming error and raises AttributeError.
    """
    package = import_module(f"fieldkit.{group}")
    names = sorted(m.name for m in iter_modules(package.__path__) if not (m.ispkg or m.name.startswith("_")))
    modules = {name: import_module(f"{package.__name__}.{name}") for name in names}
    return MappingProxyType({name: getattr(module, attribute) for name, module in modules.items()})


def trained() -> list[str]:
    """The names of the trained ensembles, in alphabetical order: each is a folder with a `card.json`."""
    folder = plugin_folder("models") / "trained"
    return sorted(card.parent.name for card in folder.glob("*/card.json"))


def trained_digests() -> dict[str, str]:
    """The digest of each trained ensemble's graph by name, from its card; nothing is loaded or checked."""
    folder = plugin_folder("models") / "trained"
    cards = {name: json.loads((folder / name / "card.json").read_text(encoding="utf-8")) for name in trained()}
    return {name: str(card["digests"]["ensemble.onnx"]) for name, card in cards.items()}


def trained_folder(name: str) -> Path:
    """The folder of a trained ensemble. Raises DamagedModel with the available names if there is none."""
    if name not in trained():
        raise DamagedModel(f"no trained ensemble is called {name!r}; there are {', '.join(trained()) or 'none'}")
    return plugin_folder("models") / "trained" / name
