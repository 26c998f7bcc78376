"""Lists every text that users see, for translators and reviewers: `python tools/strings.py [--pot] [FOLDER ...]`.

A line has the file, the line and the text, with `{...}` for values. With `--pot` it is a catalog in the format of GNU
gettext, which `msginit`, Poedit and Weblate read: each text once with all its places, its values numbered from `{0}`.
Texts are strings of two or more words in the packages below, labels of one capitalized word, and titles, without
docstrings; those of commands are included, because they are help. Without folders, all packages with such texts are
listed.
"""

import ast
import re
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import count
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("fieldkit", "parsers", "models")
NOT_SHOWN = (
    "fieldkit/importing/tables/headings.py",
    "fieldkit/inference/training",
    "fieldkit/inference/validation",
    "fieldkit/ledger/migrations",
    "fieldkit/motors/names.py",
    "fieldkit/presentation/report/style.py",
    "fieldkit/tui/themes.py",
)
"""Code whose strings are settings, schemas, names of fonts, or words that are looked for in files."""
WORDS = re.compile(r"[A-Za-z]{2,}\W*\s\W*[A-Za-z]")
PHRASE = re.compile(r"(^|\s)[A-Za-z]{3,}[,:;.]?\s|\s[A-Za-z]{3,}[,:;.]?$")
"""A word beside a value: `centered {...}`."""
LABEL = re.compile(r"[A-Z][a-z]{2,}[.!?:]?")
COUNTED = re.compile(r"\{\.\.\.\} (?:(?:such|more|earlier|clean|other) )*[a-z]+s")
"""A count with its noun: `{...} flights`."""
HEADINGS = re.compile(r"_?(headers|headings|(DIFFERENCE_)?HEADERS|HEADINGS|LABELS)")
"""Names of the headings of a table, and of its labels."""
SHOWN_LITERALS = ("Verdict", "ForecastState")
"""Literal types whose values are shown as words."""
TITLES = ("title", "help", "tooltip", "empty", "enter", "explains", "tell_apart")
"""Arguments whose values are shown, even a single word in lower case."""
PATTERNS = ("compile", "fullmatch", "match", "search", "sub", "split", "findall", "finditer", "text", "cast")
"""Functions whose first argument is a regular expression, a statement in SQL, or a type."""
AXES = ("Float", "Int", "Bool")
"""Types of arrays, whose strings are names of axes."""
_IS_CODE = re.compile(
    "|".join(
        (
            r"^[^{]*\{[^}]*:[^}]*;",  # rules of style
            r"^[a-z-]+: [\w$%.#-]+( [\w$%.#-]+){0,2};",
            r"^[\w.-]+=\S*$",
            r"^\$?[-#.&][\w-]",  # selectors, options
            r"^\w+(_\w+)+",  # keys
            r"^https?:|->|^<\?xml|^default-src|^<meta",
            r"^[\w.]+(\[.*\])?( \| [\w.\[\], ]+)+$|^[A-Za-z]\w*\[",  # types
            r"^(SELECT|PRAGMA|ATTACH|BEGIN|synchronous) ",
            r"^(offset points|axes fraction)$",  # coordinates of a plot
        )
    )
)
"""Strings of several words that nobody sees."""


@cache
def strings(file: Path) -> Sequence[tuple[int, str]]:
    """Line and text of each user-facing string of a module, in the order of the code."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    nodes = list(ast.walk(tree))
    commands = _registered(tree) if "/cli/" in file.as_posix() else None
    hidden = {id(text) for text in _docstrings(nodes, commands)}
    hidden |= {id(part) for part in _patterns(nodes)}
    parts = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in ast.walk(node)} | hidden
    types, titles = {id(part) for part in _types(nodes)}, {id(part) for part in (*_titles(nodes), *_named(nodes))}
    found = []
    for node in nodes:
        text = None
        if isinstance(node, ast.JoinedStr) and id(node) not in hidden:
            text = "".join(
                part.value if isinstance(part, ast.Constant) and isinstance(part.value, str) else "{...}"
                for part in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in parts:
            text = node.value
        elif isinstance(node, ast.Call) and (noun := _counted_noun(node)):
            found.append((node.lineno, f"{{...}} {noun}s"))
        is_code = bool(text and _IS_CODE.search(text.replace("{...}", "…").strip()))
        is_label = bool(text and LABEL.fullmatch(text)) and id(node) not in types
        is_text = bool(text and WORDS.search(text)) or (
            isinstance(node, ast.JoinedStr) and bool(PHRASE.search(text or ""))
        )
        is_title = id(node) in titles and bool(re.search("[A-Za-z]{2}", text or ""))
        if text and (is_label or is_text or is_title) and not (is_code and not (is_title and " " in text)):
            found.append((node.lineno, " ".join(text.split())))
    return sorted(set(found))


def _counted_noun(call: ast.Call) -> str | None:
    """The noun of `counted(number, "flight")`."""
    noun = call.args[1] if len(call.args) == 2 and _name(call.func) == "counted" else None
    return str(noun.value) if isinstance(noun, ast.Constant) else None


def _named(nodes: Sequence[ast.AST]) -> Iterator[ast.Constant]:
    """Headings and labels of tables, and the values of literal types that are shown."""
    for node in nodes:
        of: list[ast.expr] = []
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            name = target.id if isinstance(target, ast.Name) else ""
            of = [node.value] if name in SHOWN_LITERALS or HEADINGS.fullmatch(name) else []
        elif isinstance(node, ast.Call) and _name(node.func) == "print_table":
            of = node.args[:1]
        yield from (one for value in of for one in ast.walk(value) if isinstance(one, ast.Constant))


def _types(nodes: Sequence[ast.AST]) -> Iterator[ast.AST]:
    """Everything in annotations and in `__all__`, whose strings are names of code."""
    for node in nodes:
        if isinstance(node, ast.Assign) and any(isinstance(to, ast.Name) and to.id == "__all__" for to in node.targets):
            yield from ast.walk(node.value)
        for annotation in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if isinstance(annotation, ast.AST):
                yield from ast.walk(annotation)


def _patterns(nodes: Sequence[ast.AST]) -> Iterator[ast.AST]:
    """Regular expressions, statements in SQL, and names of axes and types."""
    for node in nodes:
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id in AXES:
            yield from ast.walk(node.slice)
        if isinstance(node, ast.Call) and node.args and _name(node.func) in PATTERNS:
            yield from ast.walk(node.args[0])


def _name(function: ast.expr) -> str:
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _titles(nodes: Sequence[ast.AST]) -> Iterator[ast.Constant]:
    """Values of arguments in `TITLES`."""
    for node in nodes:
        for argument in node.keywords if isinstance(node, ast.Call) else []:
            value = argument.value
            if argument.arg in TITLES and isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value


def _registered(tree: ast.Module) -> set[str]:
    """Functions that a module registers as commands by a call."""
    return set(re.findall(r"\.command\([^()]*\)\((\w+)\)", ast.unparse(tree)))


def _docstrings(nodes: Sequence[ast.AST], commands: set[str] | None) -> Iterator[ast.Constant]:
    """Docstrings of modules, classes, functions and constants; not of commands, in a module that may have some."""
    for node in nodes:
        for statement in getattr(node, "body", []) if not isinstance(node, ast.Lambda | ast.IfExp) else []:
            is_text = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
            is_command = commands is not None and isinstance(node, ast.FunctionDef) and _is_command(node, commands)
            if is_text and not is_command:
                yield statement.value


def _is_command(node: ast.FunctionDef, registered: set[str]) -> bool:
    """Whether a docstring is help: that of a function that the command line registers."""
    decorators = [ast.unparse(one) for one in node.decorator_list]
    return node.name in registered or any(re.search(r"\.(command|callback)\b", one) for one in decorators)


def template_strings(file: Path) -> Iterator[tuple[int, str]]:
    """Line and text of each text of a template, tags and style left out, values as `{...}`."""
    text = re.sub(r"<style.*?</style>", lambda one: "\n" * one[0].count("\n"), file.read_text("utf-8"), flags=re.DOTALL)
    text = re.sub(r"\{\{.*?\}\}", "{...}", re.sub(r"\{%.*?%\}", "", text))
    for number, line in enumerate(text.splitlines(), start=1):
        parts = [*re.findall(r' alt="([^"]*)"', line), *re.split(r"<[^>]*>", line)]
        yield from ((number, part.strip()) for part in parts if re.search("[A-Za-z]{2}", part.replace("...", "")))


def texts(folders: tuple[str, ...] = FOLDERS) -> Iterator[tuple[str, int, str]]:
    """File, line and text of all strings, module by module, then template by template."""
    for folder in folders:
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            if not name.startswith(NOT_SHOWN):
                yield from ((name, line, text) for line, text in strings(file))
        for file in sorted((ROOT / folder).rglob("*.html")):
            name = file.relative_to(ROOT).as_posix()
            yield from ((name, line, text) for line, text in template_strings(file))


def listed(folders: tuple[str, ...] = FOLDERS) -> Iterator[str]:
    """A line for each text, with its file and line."""
    yield from (f"{name}:{line}: {text}" for name, line, text in texts(folders))


def catalog(folders: tuple[str, ...] = FOLDERS) -> Iterator[str]:
    """Lines of a `.pot` catalog: each text once, with its places."""
    places: dict[str, list[str]] = {}
    for name, line, text in texts(folders):
        places.setdefault(text, []).append(f"#: {name}:{line}")
    yield from ('msgid ""', 'msgstr ""', '"Project-Id-Version: fieldkit\\n"', '"MIME-Version: 1.0\\n"')
    yield '"Plural-Forms: nplurals=2; plural=(n != 1);\\n"'
    yield from ('"Content-Type: text/plain; charset=UTF-8\\n"', '"Content-Transfer-Encoding: 8bit\\n"')
    for text, references in places.items():
        number = count()
        numbered = re.sub(r"\{\.\.\.\}", lambda _: f"{{{next(number)}}}", text)  # noqa: B023  # called here
        form = ["#, python-brace-format"] if numbered != text else []
        escaped = numbered.replace("\\", "\\\\").replace('"', '\\"')
        yield from ("", *dict.fromkeys(references), *form)
        if COUNTED.fullmatch(text):
            yield from (f'msgid "{escaped[:-1]}"', f'msgid_plural "{escaped}"', 'msgstr[0] ""', 'msgstr[1] ""')
        else:
            yield from (f'msgid "{escaped}"', 'msgstr ""')


if __name__ == "__main__":
    arguments = sys.argv[1:]
    chosen = tuple(one for one in arguments if one != "--pot") or FOLDERS
    sys.stdout.writelines(f"{line}\n" for line in (catalog if "--pot" in arguments else listed)(chosen))
