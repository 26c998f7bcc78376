"""Public functions say what they return, in which unit, and which errors they raise."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldkit import errors
from tests.raised_errors import Function, RaisedErrors

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
    "inference/network/posterior.py": "looks up what was recorded",
    "model/features.py": "arranges what was recorded",
    "model/sources.py": "looks up how a readout was recorded",
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

RENDERED = ("cli/", "presentation/")
"""Commands, whose errors `cli/main.py` prints, and pages of results that were computed before: here only errors that a
function raises itself are to be documented."""
OWN_ARGUMENTS = frozenset({"unit"})
"""Functions that raise an error for a name that only the program writes."""
NOT_RAISED = {
    "ledger/book.py:add": "a flight that cannot be stored is a conflict",
    "reference/flights.py:reference": "the flights are shipped",
    "reference/report.py:pass_forecasts": "the flights are shipped",
    "reference/report.py:report": "the flights are shipped",
    "services/demo.py:demo": "the flights are shipped",
}
"""Functions that do not raise what they seem to. In `services/`, flights without a dry mass are left out."""

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


def test_every_public_function_has_a_docstring(modules: Modules) -> None:
    found = [
        f"{name}:{function.lineno}: {function.name}"
        for name, tree in modules
        for function in _public(tree)
        if not ast.get_docstring(function)
    ]
    assert not found, "\n".join(found)


def test_numbers_that_a_function_takes_or_returns_have_a_unit(modules: Modules) -> None:
    """A unit in brackets, `[m]` or `[1]`, or in words: SI, or the unit of something else. Those of `cli/` are options,
    which state the unit in their help."""
    found = [
        f"{name}:{function.lineno}: {function.name}"
        for name, tree in modules
        for function in _public(tree)
        if any(re.match(r"float\b|Float\[", hint) for hint in _hints(function, arguments=not name.startswith("cli/")))
        and not re.search(r"\[[^\]]+\]|\bSI\b|\bunits?\b", ast.get_docstring(function) or "")
    ]
    assert not found, "\n".join(found)


def test_arrays_that_a_function_takes_have_named_axes(modules: Modules) -> None:
    """In their type, or in words, in which case they are not checked: in inner loops, or if shapes are broadcast."""
    found = [
        f"{name}:{function.lineno}: {function.name}"
        for name, tree in modules
        for function in _public(tree)
        if any(re.search(r"(?<![\[(])\bArray\b(?! *\])|, Array\]|np\.ndarray", hint) for hint in _hints(function))
        and not re.search(r"elementwise|Elementwise|\bentry per\b|\[axis draw\]", ast.get_docstring(function) or "")
    ]
    assert not found, "\n".join(found)


def _hints(function: Function, *, arguments: bool = True) -> list[str]:
    """The annotations of what a function returns and, with `arguments`, takes, except for functions."""
    taken = (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs) if arguments else ()
    hints = [*(one.annotation for one in taken), function.returns]
    return [text for hint in hints if hint is not None if not (text := ast.unparse(hint)).startswith("Callable")]


@pytest.fixture(scope="module")
def raised(modules: Modules) -> RaisedErrors:
    return RaisedErrors({_dotted(name): tree for name, tree in modules}, OWN_ARGUMENTS)


def _dotted(path: str) -> str:
    return f"fieldkit/{path}".removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def test_a_function_that_raises_our_errors_documents_them(modules: Modules, raised: RaisedErrors) -> None:
    """Each error, or one above it, is named, or the errors of another function are: `errors as in`, `errors of`."""
    assert {"FieldkitError", "BadValue", "PortLost"} <= raised.above.keys()
    found = {
        f"{name}:{function.name}": lacking
        for name, tree in modules
        for commands in [_commands(tree) if name.startswith("cli/") else set()]
        for function in _public(tree)
        if function.name not in commands
        if (lacking := _undocumented(name, function, raised))
    }
    assert found.keys() >= NOT_RAISED.keys(), "an exception is no longer needed"
    assert found.keys() <= NOT_RAISED.keys(), {name: found[name] for name in found.keys() - NOT_RAISED.keys()}


@pytest.mark.parametrize(
    ("body", "errors"),
    [
        ("raise BadValue('x')", {"BadValue"}),
        ("return [read(one) for one in rows]", {"DamagedLog"}),
        ("try:\n  read(rows)\n except FieldkitError:\n  pass", set()),
        ("try:\n  read(rows)\n except BadValue:\n  pass", {"DamagedLog"}),
        ("with suppress(DamagedLog):\n  read(rows)", set()),
        ("raise ValueError", set()),
    ],
)
def test_errors_are_found_through_calls_unless_they_are_caught(body: str, errors: set[str]) -> None:
    helper = (
        "class BadValue(FieldkitError): pass\nclass DamagedLog(FieldkitError): pass\ndef read(x):\n raise DamagedLog"
    )
    modules = {"a": ast.parse(helper), "b": ast.parse(f"from a import read\ndef f(rows):\n {body}")}
    function = modules["b"].body[1]
    assert isinstance(function, Function)
    assert RaisedErrors(modules).of("b", function) == errors


def _undocumented(name: str, function: Function, raised: RaisedErrors) -> set[str]:
    docstring = ast.get_docstring(function) or ""
    if re.search(r"\berrors\s+(as\s+in|of)\s+`", docstring, re.IGNORECASE):
        return set()
    errors = raised.of(_dotted(name), function, calls=not name.startswith(RENDERED))
    if name.startswith("services/"):
        errors -= {"ImpossibleFlight"}
    return {error for error in errors if not any(re.search(rf"\b{one}\b", docstring) for one in raised.above[error])}


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
