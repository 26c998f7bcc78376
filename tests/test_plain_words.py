"""Text that people read keeps to the glossary: messages, help, docstrings, comments, the manual."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

ROOT = Path(__file__).parents[1]
FOLDERS = ("fieldkit", "parsers", "models", "studies", "bench", "tools")
MIGRATIONS = "fieldkit/ledger/migrations/versions/"
"""Steps of the ledger's schema, which are never edited after a release."""
GLOSSARY = ROOT / "docs/glossary.md"

LEFT_COLUMN = """
    afresh, alike, anew, apart by, askew, begun, evened, farewell, foretell, foretells, foretold, hopeless, in
    hand, lean, leans, learnt, long work shared out, luck, lucks, lucky, oddities, one to the next alike,
    overheard, overhears, railed, reflown, roughly, says nothing of, seldom, share of, shelf, shelves, small
    matrices turned over, steps back, surer, takes it back, taught, teach, teaches, tell, telling, tells, testify,
    testimony, there already, thinning, told, unlike, untold, wander, wanders, warmth, witness, woken
"""
"""Words of the left column of the glossary that have no ordinary meaning here; `took` and `steady` have one."""
DIALECT = """
    a good deal, albeit, are said, askance, bear out, bears, bears out, borne, for want of, forthwith, gravely, gravest,
    go on, go together, goes on, goes together, going on, hang together, hangs together, heed, henceforth, herein,
    heretofore, hitherto, in so far, inasmuch, insofar, is said, is told, lest, mend, mended, mends, naught, nigh,
    notwithstanding, of itself, on record, ought, reckon, reckoned, reckons, said so, say so, says so, shall, so long
    as, some sixty, that is none, thereby, therein, thereof, thereupon, thrice, to and fro, unasked, unto, went on,
    whence, whereby, wherever, whilst, whoever
"""
"""Words that a native speaker would not write here, besides those of the glossary."""
BRITISH = """
    analyse, behaviour, catalogue, centre, centres, colour, colours, favour, grey, judgement, licence, metre, metres,
    neighbour, recognise, recognised, recognises, towards
"""
"""Spellings that are not American."""
WORDS = tuple(word.strip() for word in " ".join(f"{LEFT_COLUMN}, {DIALECT}, {BRITISH}".split()).split(","))
BANNED = re.compile(
    r"(?<![\w-])(" + "|".join(sorted(map(re.escape, WORDS), key=len, reverse=True)) + r")(?![\w-])", re.I
)
QUOTED = re.compile(r"`[^`]*`|\{[^}]*\}|“[^”]*”")
"""Names of code, fields of a message and quoted rules are nobody's words."""

QUOTES = {
    "cannot tell": "a value of `beside_verdict` in the JSON of a loop, which programs may compare with",
    "masses not on record": "a key in the shipped catalog of motors",
    "meter meters metre metres mtr metro metros mètre mètres metri м": "names of a unit in the headers of tables",
}
"""Whole texts that may hold a banned word, each with its reason: at most ten."""


def _python_texts(file: Path) -> Iterator[tuple[int, str]]:
    """Comments and strings of more than one word, docstrings among them, with their first lines."""
    source = file.read_text(encoding="utf-8")
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.search(r"\w\s+\w", node.value):
            yield node.lineno, node.value


def _texts() -> Iterator[tuple[str, int, str]]:
    """Everything that is read: the file, a line, and the text."""
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            if name.startswith(MIGRATIONS):
                continue
            yield from ((name, line, text) for line, text in _python_texts(file))
    for page in (ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))):
        if page != GLOSSARY:
            name = page.relative_to(ROOT).as_posix()
            yield name, 1, re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def banned_words(text: str) -> list[str]:
    """The banned words of a text, in lower case."""
    return [found.lower() for found in BANNED.findall(" ".join(QUOTED.sub("", text).split()))]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("asks for it anew", ["anew"]),
        ("Lines told\n  of a flight", ["told"]),
        ("a share\n    of the area", ["share of"]),
        ("`told` is a name, {told} a field", []),
        ("leaning, retold", []),
    ],
)
def test_banned_words_are_found_in_text_and_not_in_code(text: str, words: list[str]) -> None:
    assert banned_words(text) == words


def test_text_that_people_read_holds_no_word_that_the_glossary_replaces() -> None:
    found = [
        f"{name}:{line}: {word}: {' '.join(text.split())[:100]}"
        for name, line, text in _texts()
        for word in banned_words(text)
        if text not in QUOTES
    ]
    assert not found, "\n".join(found)


def test_few_lines_are_excepted_and_each_has_a_reason() -> None:
    assert len(QUOTES) <= 10
    assert all(QUOTES.values())
    texts = {text for _, _, text in _texts()}
    assert [quote for quote in QUOTES if quote not in texts] == []


def test_the_glossary_has_every_word_of_its_left_column_that_is_looked_for() -> None:
    rows = [line for line in GLOSSARY.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    left = " ".join(re.sub(r"[()]", "", row.split("|")[1]) for row in rows)
    words = [word.strip() for word in " ".join(LEFT_COLUMN.split()).split(",")]
    assert [word for word in words if word not in " ".join(left.split())] == []
