"""The program uses only public names of libraries: private ones may disappear in the next release."""

import ast
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.fast

ROOT = Path(__file__).parent.parent
FILES = sorted(file for folder in ("fieldkit", "parsers", "models") for file in (ROOT / folder).rglob("*.py"))

PUBLIC = {"_asdict", "_fields", "_replace"}
"""Documented methods and attributes of named tuples, with an underscore so that they are not fields."""
ALLOWED = {"fieldkit/tui/serve.py: super()._make_app"}
"""The only exception: a guard that runs before every answer of `textual_serve`, including files. Its public handlers
omit one of the four routes; without it, 40 lines of the server would be repeated here."""


def _own_names(trees: Iterable[ast.Module]) -> set[str]:
    """Private names that the program itself defines: functions, classes, fields, attributes that it sets."""
    found: set[str] = set()
    for tree in trees:
        for node in ast.walk(tree):
            match node:
                case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                    found.add(name)
                case ast.Attribute(attr=name, value=ast.Name(id="self"), ctx=ast.Store()):
                    found.add(name)
                case ast.Name(id=name, ctx=ast.Store()):
                    found.add(name)
    return found


def _is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in PUBLIC


def strange(tree: ast.Module, own: set[str]) -> Iterator[str]:
    """Private attributes and modules of libraries that a module uses; documented names such as `os._exit` are
    allowed."""
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name, value=ast.Call(func=ast.Name(id="super"))) if _is_private(name):
                yield ast.unparse(node)
            case ast.Attribute(attr=name, value=ast.Name(id=base)) if base in sys.stdlib_module_names:
                pass
            case ast.Attribute(attr=name) if _is_private(name) and name not in own:
                yield ast.unparse(node)
            case ast.ImportFrom(module=str(module), level=0, names=names):
                parts = [*module.split("."), *(one.name for one in names)]
                if any(map(_is_private, parts)) and parts[0] != "fieldkit":
                    yield ast.unparse(node)
            case ast.Call(func=ast.Name(id="getattr" | "setattr"), args=[_, ast.Constant(value=str(name)), *_]):
                if _is_private(name) and name not in own:
                    yield ast.unparse(node)


@pytest.mark.parametrize(
    "line",
    [
        "widget._nodes.clear()",
        "self._css_update_count = self.app._css_update_count",
        "super()._make_app()",
        "from textual._xterm_parser import XTermParser",
        "getattr(app, '_modes')",
    ],
)
def test_private_attributes_of_libraries_are_found(line: str) -> None:
    assert list(strange(ast.parse(line), {"_own"}))


@pytest.mark.parametrize(
    "line", ["self._own", "other._own", "os._exit(0)", "value.__class__", "from fieldkit import __version__"]
)
def test_the_programs_own_private_attributes_are_not_reported(line: str) -> None:
    assert not list(strange(ast.parse(line), {"_own"}))


@pytest.mark.thorough
def test_no_private_attribute_of_a_library_is_used() -> None:
    trees = {file: ast.parse(file.read_text(encoding="utf-8")) for file in FILES}
    own = _own_names(trees.values())
    found = {
        f"{file.relative_to(ROOT).as_posix()}: {name}" for file, tree in trees.items() for name in strange(tree, own)
    }
    assert found == ALLOWED
