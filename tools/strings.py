"""Lists every text that users see, for translators and reviewers: `python tools/strings.py [FOLDER ...]`.

A line has the file, the line and the text, with `{...}` for values. Texts are strings of two or more words in the
packages below, labels of one capitalized word, and titles, without docstrings; those of commands are included, because
they are help. Without folders, all packages with such texts are listed.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("fieldkit", "parsers", "models")
NOT_SHOWN = ("fieldkit/inference/training", "fieldkit/ledger/migrations", "fieldkit/presentation/report/style.py")
"""Code whose strings are settings, schemas or names of fonts."""
WORDS = re.compile(r"[A-Za-z]{2,}\W*\s\W*[A-Za-z]")
LABEL = re.compile(r"[A-Z][a-z]{2,}[.!?:]?")
TITLES = ("title", "help", "tooltip", "empty", "enter", "explains", "tell_apart")
"""Arguments whose values are shown, even a single word in lower case."""
_IS_CODE = re.compile(
    r"^[\w.*/#$>:\-, ]*[{;=]|^\$?[-#.&][\w-]|^\w+(_\w+)+|^https?:|->|^[\w.]+(\[.*\])?( \| [\w.\[\], ]+)+$"
)
"""Style sheets, selectors, keys, links, axes and types."""


def strings(file: Path) -> Iterator[tuple[int, str]]:
    """Line and text of each user-facing string of a module, in the order of the code."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    hidden = {id(text) for text in _docstrings(tree, keep_commands="/cli/" in file.as_posix())}
    parts = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node)}
    types, titles = {id(part) for part in _types(tree)}, {id(part) for part in _titles(tree)}
    found = []
    for node in ast.walk(tree):
        text = None
        if isinstance(node, ast.JoinedStr):
            text = "".join(
                part.value if isinstance(part, ast.Constant) and isinstance(part.value, str) else "{...}"
                for part in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and not {id(node)} & (hidden | parts):
            text = node.value
        is_label = bool(text and LABEL.fullmatch(text)) and id(node) not in types
        is_text = text and WORDS.search(text) and not _IS_CODE.search(text.replace("{...}", "…").strip())
        if text and (is_text or is_label or id(node) in titles):
            found.append((node.lineno, " ".join(text.split())))
    yield from sorted(set(found))


def _types(tree: ast.Module) -> Iterator[ast.AST]:
    """Everything in annotations and in `__all__`, whose strings are names of code."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and any(isinstance(to, ast.Name) and to.id == "__all__" for to in node.targets):
            yield from ast.walk(node.value)
        for annotation in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if isinstance(annotation, ast.AST):
                yield from ast.walk(annotation)


def _titles(tree: ast.Module) -> Iterator[ast.Constant]:
    """Values of arguments in `TITLES`."""
    for node in ast.walk(tree):
        for argument in node.keywords if isinstance(node, ast.Call) else []:
            value = argument.value
            if argument.arg in TITLES and isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value


def _docstrings(tree: ast.Module, keep_commands: bool) -> Iterator[ast.Constant]:
    """Docstrings of modules, classes, functions and constants; not of commands, if they are kept."""
    for node in ast.walk(tree):
        for statement in getattr(node, "body", []) if not isinstance(node, ast.Lambda | ast.IfExp) else []:
            is_text = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
            is_command = keep_commands and isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
            if is_text and not is_command:
                yield statement.value


def listed(folders: tuple[str, ...] = FOLDERS) -> Iterator[str]:
    """All lines, module by module."""
    for folder in folders:
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            if not name.startswith(NOT_SHOWN):
                yield from (f"{name}:{line}: {text}" for line, text in strings(file))


if __name__ == "__main__":
    sys.stdout.writelines(f"{line}\n" for line in listed(tuple(sys.argv[1:]) or FOLDERS))
