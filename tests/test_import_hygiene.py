"""Imports at the start of a command: heavy libraries only if needed. Plug-ins use only their interface."""

import ast
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from fieldkit.cli.main import HOMES
from fieldkit.flight import BY_NAME, KNOWN_TAGS

ROOT = Path(__file__).parents[1]

NEVER = {"torch", "textual", "pandas", "matplotlib", "serial"}
ALLOWED = {
    "parsers": {
        *("importing", "flight", "units", "errors", "messages", "shapes", "safe_text", "quantities"),
        "physics.standard_atmosphere",
    },
    "models/effects": {"physics", "flight", "errors", "messages", "shapes"},
}
"""Modules of the engine that the plug-ins of a folder may use."""
MODULES = {
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file
    for file in (ROOT / "fieldkit").rglob("*.py")
}


def modules_after(tmp_path: Path, *arguments: str) -> set[str]:
    """The modules that a new process has imported after a command."""
    code = (
        "import json, sys\n"
        "from fieldkit.cli.main import main\n"
        f"status = main({list(arguments)!r})\n"
        f"open({str(tmp_path / 'modules.json')!r}, 'w').write(json.dumps([status, *sys.modules]))\n"
    )
    flyer = os.environ | {"PYTHONPATH": str(ROOT), "FIELDKIT_HOME": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], env=flyer, cwd=tmp_path, capture_output=True, text=True)
    status, *modules = json.loads((tmp_path / "modules.json").read_text())
    assert status == 0, done.stderr
    return set(modules)


@pytest.fixture(scope="module")
def ledger(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The path of a ledger that holds the reference flights."""
    from fieldkit.cli.main import main

    path = str(tmp_path_factory.mktemp("hygiene") / "ledger.db")
    assert main(["--ledger", path, "import", str(ROOT / "fieldkit" / "data" / "reference_flights.csv")]) == 0
    return path


@pytest.mark.parametrize(
    "arguments", [["--help"], ["add", "--help"], ["predict", "--help"], ["demo", "--help"], ["capture", "--help"]]
)
def test_help_imports_nothing_heavy(tmp_path: Path, arguments: list[str]) -> None:
    heavy = NEVER | {"numpy", "scipy", "sqlalchemy", "alembic", "onnxruntime", "sqlite3"}
    assert not heavy & modules_after(tmp_path, *arguments)


def test_listing_flights_imports_only_the_ledger(tmp_path: Path, ledger: str) -> None:
    modules = modules_after(tmp_path, "--ledger", ledger, "flights")
    assert not (NEVER | {"scipy", "scipy.optimize", "numpy", "onnxruntime"}) & modules
    assert "sqlalchemy" in modules


def test_predicting_does_not_import_training(tmp_path: Path, ledger: str) -> None:
    modules = modules_after(tmp_path, "--ledger", ledger, "predict", "--motor", "F24-4W")
    assert not (NEVER | {"onnxruntime", "alembic", "scipy.optimize", "scipy.stats"}) & modules
    assert "numpy" in modules


def test_inferring_does_not_import_training_and_only_the_papers_network_is_run(tmp_path: Path, ledger: str) -> None:
    modules = modules_after(tmp_path, "--ledger", ledger, "infer", "1")
    assert not (NEVER | {"onnx", "onnxruntime", "scipy.optimize"}) & modules
    assert "onnxruntime" in modules_after(tmp_path, "--ledger", ledger, "infer", "1", "--model", "paper")


def imports(file: Path) -> Iterator[str]:
    """The modules of fieldkit that a file imports, below `fieldkit`."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module == "fieldkit":
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("fieldkit."):
            yield node.module.partition(".")[2]
        elif isinstance(node, ast.Import):
            yield from (name.name.partition(".")[2] for name in node.names if name.name.split(".")[0] == "fieldkit")


@pytest.mark.parametrize("folder", ALLOWED)
def test_plug_ins_import_the_engine_and_not_each_other(folder: str) -> None:
    files = sorted((ROOT / folder).glob("*.py"))
    assert files
    for file in files:
        strange = [name for name in imports(file) if not any(f"{name}.".startswith(f"{a}.") for a in ALLOWED[folder])]
        assert not strange, file.name


def test_the_engine_names_no_effect() -> None:
    """Effects are found only by the registry; names that are also those of a column, a tag or a command are left
    out."""
    names = {file.stem for file in (ROOT / "models" / "effects").glob("*.py")}
    names -= BY_NAME.keys() | KNOWN_TAGS.keys() | HOMES.keys()
    assert len(names) > 8
    for file in (ROOT / "fieldkit").rglob("*.py"):
        source = file.read_text(encoding="utf-8")
        nodes = ast.walk(ast.parse(source)) if any(name in source for name in names) else ()
        assert not names & {node.value for node in nodes if isinstance(node, ast.Constant)}, file


def test_the_engine_names_no_parser() -> None:
    """In `capture` and `openrocket` the same words name devices and a program."""
    names = {file.stem for file in (ROOT / "parsers").glob("*.py")}
    assert len(names) > 25
    found = [
        f"{file.relative_to(ROOT)}: {node.value}"
        for file in (ROOT / "fieldkit").rglob("*.py")
        if file.relative_to(ROOT).parts[1] not in ("capture", "openrocket")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in names
    ]
    assert found == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Imports for type checkers and inside functions count too."""
    graph = {name: set(imported(file)) - {name} for name, file in MODULES.items()}
    assert graph["fieldkit.tui.app"]
    TopologicalSorter(graph).prepare()  # CycleError names the modules of a circle


def imported(file: Path) -> Iterator[str]:
    """The modules of fieldkit that a file imports; for `from a import b` it is `a.b` if that is a module."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            whole = [f"{node.module}.{name.name}" for name in node.names]
            names = [one if one in MODULES else node.module for one in whole]
        elif isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        else:
            continue
        yield from (name for name in names if name in MODULES)


def test_commands_import_at_the_top_what_they_have_loaded_anyway() -> None:
    """An import in a function buys nothing if a module of the command line has imported the same at its top."""
    commands = [name for name in MODULES if name.startswith("fieldkit.cli.")]
    assert len(commands) > 30
    for command in commands:
        assert not imported_inside(command) & at_start({command, "fieldkit.cli.main"}), command


def test_only_what_the_first_page_shows_imports_inside_functions_in_the_app() -> None:
    """Other pages are imported when they are first shown, with everything that they need."""
    loaded = at_start({"fieldkit.tui.app", "fieldkit.tui.home.home_page"})
    pages = [name for name in MODULES if name.startswith("fieldkit.tui.")]
    assert len(set(pages) & loaded) < 40 < len(pages)
    for page in pages:
        inner = imported_inside(page)
        assert not (inner & loaded if page in loaded else inner), page


def test_the_app_loads_matplotlib_only_for_a_report() -> None:
    """It takes 40 MB, a quarter of the app's memory."""
    loaded = at_start({name for name in MODULES if name.startswith("fieldkit.tui.")}) & MODULES.keys()
    assert len(loaded) > 200
    for name in loaded:
        taken = [node for node in top_level(MODULES[name]) if isinstance(node, ast.Import | ast.ImportFrom)]
        assert "matplotlib" not in " ".join(map(ast.unparse, taken)), name


def imported_inside(module: str) -> set[str]:
    """What the functions of a module import, by its full name."""
    return {
        f"{node.module}.{name.name}"
        for function in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8")))
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
        for node in ast.walk(function)
        if isinstance(node, ast.ImportFrom)
        for name in node.names
    }


@pytest.mark.parametrize(
    "layer", ["planning", "forecast", "selection", "inference", "model", "reference", "analysis", "physics", "motors"]
)
def test_texts_of_further_columns_are_not_read_in_the_core(layer: str) -> None:
    files = [file for name, file in MODULES.items() if name.startswith(f"fieldkit.{layer}.")]
    assert files
    assert not [str(file) for file in files if ".extra" in file.read_text(encoding="utf-8")]


def at_start(first: set[str]) -> set[str]:
    """The modules that are loaded when some are imported, and every name that these bind; not the names that a package
    imports only when they are used."""
    waiting, loaded, names = list(first), set[str](), set[str]()
    while waiting:
        module = waiting.pop()
        if module in loaded:
            continue
        loaded.add(module)
        for node in top_level(MODULES[module]):
            match node:
                case ast.ImportFrom(module=str(source)):
                    whole = {f"{source}.{name.name}" for name in node.names}
                    names |= {f"{module}.{name.asname or name.name}" for name in node.names}
                    waiting += [one for one in {source, *whole} if one in MODULES]
                case ast.Import():
                    waiting += [name.name for name in node.names if name.name in MODULES]
                case ast.FunctionDef() | ast.ClassDef():
                    names.add(f"{module}.{node.name}")
                case ast.Assign() | ast.AnnAssign():
                    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                    names |= {f"{module}.{target.id}" for target in targets if isinstance(target, ast.Name)}
    return loaded | names


@cache
def top_level(file: Path) -> list[ast.stmt]:
    """The statements of a module; those for type checkers are in a block of their own."""
    return ast.parse(file.read_text(encoding="utf-8")).body
