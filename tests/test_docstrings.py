"""Public functions say what they return, in which unit, and which errors they raise."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldkit import errors

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

PACKAGE = Path(errors.__file__).parent
LEFT_OUT = ("tui/", "ledger/migrations/versions/")
"""Screens, whose methods the library names; migrations, which are never edited and whose modules say what they do."""

SOURCED = (
    "physics/",
    "analysis/",
    "model/",
    "inference/laplace/",
    "inference/history/",
    "inference/network/",
    "selection/",
    "scoring/",
    "forecast/",
    "planning/",
    "motors/",
)
"""Packages whose functions compute by formulas of physics and statistics."""
NO_FORMULA = {
    "analysis/labels.py": "converts units",
    "inference/history/shards.py": "arranges figures in a table",
    "inference/history/unexplained_patterns.py": "draws patterns that are invented on purpose",
    "inference/network/field_ensemble.py": "looks up priors",
    "inference/network/posterior.py": "looks up what was recorded",
    "model/features.py": "arranges what was recorded",
    "model/rocket_model.py": "looks up how a readout was recorded; `reference_area` names its derivation",
    "motors/comparison.py": "looks up the catalog",
    "motors/draft.py": "parses text",
    "physics/setups.py": "looks up what was recorded; `turn_lengths` names its source",
    "physics/single.py": "converts units",
    "planning/air.py": "looks up what was recorded",
    "planning/contest_day.py": "parses what was announced",
    "planning/finals.py": "lists the targets of a season",
    "planning/motor_guide.py": "looks up what was flown",
    "planning/toml_values.py": "reads numbers from files",
    "planning/quantiles.py": "names three numbers",
    "selection/candidates.py": "marks flights by their group",
    "selection/covariates.py": "looks up what was recorded",
}
"""Modules in those packages without formulas of their own, each with its reason."""
SOURCE = re.compile(r"\bSource: |\bDerivation: |\b(1[6-9]\d\d|20[0-2]\d)\b|\bNFPA \d")
"""A source, such as an author with a year or a standard, or a derivation."""
NUMBERS = re.compile(r"\bfloat\b|\bFloat\[|\bArray\b|\bFigure\b")
"""Annotations of functions that return computed numbers."""

Function = ast.FunctionDef | ast.AsyncFunctionDef
Modules = list[tuple[str, ast.Module]]


@pytest.fixture(scope="module")
def modules() -> Modules:
    """Every module by its path, parsed."""
    files = {file.relative_to(PACKAGE).as_posix(): file for file in sorted(PACKAGE.rglob("*.py"))}
    return [
        (name, ast.parse(file.read_text(encoding="utf-8")))
        for name, file in files.items()
        if not name.startswith(LEFT_OUT)
    ]


def _public(node: ast.AST) -> Iterator[Function]:
    """Functions and methods without a leading underscore, nor in a class that has one or in another function."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef) and not child.name.startswith("_"):
            yield from _public(child)
        elif isinstance(child, Function) and not child.name.startswith("_") and not _is_stub(child):
            yield child
        elif isinstance(child, ast.If | ast.Try):
            yield from _public(child)


def _is_stub(function: Function) -> bool:
    """Whether it is a member of a protocol, whose class says what it is."""
    only = function.body[0]
    return isinstance(only, ast.Expr) and isinstance(only.value, ast.Constant) and only.value.value is ...


def _commands(tree: ast.Module) -> set[str]:
    """Functions that are commands: their docstring is the help, and the command line catches every error."""
    decorated = {
        node.name
        for node in ast.walk(tree)
        if isinstance(node, Function) and any("app.command" in ast.unparse(one) for one in node.decorator_list)
    }
    return decorated | set(re.findall(r"app\.command\(\)\((\w+)\)", ast.unparse(tree)))


def _raised(node: ast.AST) -> Iterator[str]:
    """Names of the exceptions raised directly in a body."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Function | ast.Lambda | ast.ClassDef):
            continue
        if isinstance(child, ast.Raise) and child.exc is not None:
            error = child.exc.func if isinstance(child.exc, ast.Call) else child.exc
            yield ast.unparse(error).split(".")[-1]
        yield from _raised(child)


def _errors(modules: Modules) -> set[str]:
    """`FieldkitError` and every class of the program below it."""
    bases = {
        node.name: {ast.unparse(base).split(".")[-1] for base in node.bases}
        for _, tree in modules
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    }
    found = {"FieldkitError"}
    while new := {name for name, above in bases.items() if above & found} - found:
        found |= new
    return found


def test_every_public_function_has_a_docstring(modules: Modules) -> None:
    found = [
        f"{name}:{function.lineno}: {function.name}"
        for name, tree in modules
        for function in _public(tree)
        if not ast.get_docstring(function)
    ]
    assert not found, "\n".join(found)


def test_a_function_that_returns_numbers_states_their_unit(modules: Modules) -> None:
    """A unit in brackets, `[m]` or `[1]`, or in words: SI, or the unit of something else."""
    found = [
        f"{name}:{function.lineno}: {function.name}"
        for name, tree in modules
        for function in _public(tree)
        if function.returns is not None
        and re.match(r"float\b|Float\[", ast.unparse(function.returns))
        and not re.search(r"\[[^\]]+\]|\bSI\b|\bunits?\b", ast.get_docstring(function) or "")
    ]
    assert not found, "\n".join(found)


def test_a_function_that_raises_our_errors_documents_them(modules: Modules) -> None:
    ours = _errors(modules)
    assert {"FieldkitError", "BadValue", "PortTrouble"} <= ours
    found = [
        f"{name}:{function.lineno}: {function.name} raises {', '.join(raised)}"
        for name, tree in modules
        for function in _public(tree)
        if (raised := sorted(set(_raised(function)) & ours))
        and function.name not in _commands(tree)
        and not re.search(r"\bRaises?\b", ast.get_docstring(function) or "")
    ]
    assert not found, "\n".join(found)


def _without_source(tree: ast.Module) -> list[str]:
    """Public functions of a module that return numbers, if neither it nor the function names a source or derivation."""
    above = ast.get_docstring(tree) or ""
    return [
        function.name
        for function in tree.body
        if isinstance(function, Function) and not function.name.startswith("_")
        if function.returns is not None and NUMBERS.search(ast.unparse(function.returns))
        if not SOURCE.search(f"{above}\n{ast.get_docstring(function) or ''}")
    ]


def test_formulas_name_their_source_or_derivation(modules: Modules) -> None:
    lacking = {name: found for name, tree in modules if name.startswith(SOURCED) and (found := _without_source(tree))}
    assert lacking.keys() >= NO_FORMULA.keys(), "an exception is no longer needed"
    assert lacking.keys() <= NO_FORMULA.keys(), {name: lacking[name] for name in lacking.keys() - NO_FORMULA.keys()}
