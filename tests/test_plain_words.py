"""Text that people read keeps to the glossary: messages, help, docstrings, comments, the manual."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tools.strings import texts

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

ROOT = Path(__file__).parents[1]
FOLDERS = ("fieldkit", "parsers", "models", "studies", "bench", "tools", "tests")
MIGRATIONS = "fieldkit/ledger/migrations/versions/"
"""Steps of the ledger's schema, which are never edited after a release."""
THIS = {"tests/test_plain_words.py", "tests/test_glossary.py"}
"""The files with the words themselves."""
GLOSSARY = ROOT / "docs/words.md"

ORDINARY = {
    "a fit that steps back": "`steps back` is looked for",
    "apart": "ordinary in `two kilometers apart`; `apart by` is looked for",
    "arrival": "the time when bytes arrive",
    "closing": "closing a file, closing the loop",
    "desk": "ordinary of furniture",
    "fitting": "fitting a model",
    "kept": "ordinary, unless of a forecast",
    "listens": "a server listens on a port",
    "odd": "odd numbers",
    "packed": "packed bytes",
    "places": "decimal places, places where effects act",
    "pull": "pulling a cable",
    "rough": "a rough finish",
    "stands": "a person stands at a distance",
    "steady": "steady wind",
    "talk": "devices talk on a port",
    "the move of a point that is none": "`that is none` is looked for",
    "tilt": "the tilt of a rail, a term of the model",
    "took": "a command took a second",
    "turns": "a rocket turns into the wind",
    "weight": "the weight of a rocket, of a sample",
    "where": "ordinary of places; only a reader can find it instead of `if`",
}
"""Terms of the glossary's left column that are not searched for, each with its ordinary use."""


def _replaced() -> tuple[str, ...]:
    """The terms of the glossary's left column, without names of code and remarks in parentheses."""
    rows = [line for line in GLOSSARY.read_text(encoding="utf-8").splitlines() if line.startswith("|")][2:]
    cells = [re.sub(r"`[^`]*`|\([^)]*\)", "", row.split("|")[1]) for row in rows]
    return tuple(dict.fromkeys(term.strip() for cell in cells for term in cell.split(",") if term.strip()))


DIALECT = """
    a good deal, afterwards, albeit, apart by, are said, askance, bear out, bears, bears out, borne, for want of,
    forthwith, go on, go together, goes on, goes together, going on, gravely, gravest, hang together, hangs together,
    heed, henceforth, herein, heretofore, hitherto, in so far, inasmuch, insofar, is said, is told, lest, mend, mended,
    mends, naught, nigh, notwithstanding, of itself, on record, ought, reckon, reckoned, reckons, said so, say so, says
    nothing of, says so, shall, so long as, some sixty, that is none, the page Add, the page Flights, the page Home, the
    page Import, the page Loop, the page Fly, the page Setup, thereby, therein, thereof, thereupon, thrice, to and fro,
    unasked, unto, went on, what it is worth, whence, whereby, wherever, whilst, whoever
"""
"""Words that a native speaker would not write here, besides those of the glossary, and parts of its phrases."""
BRITISH = """
    aluminium, analyse, behaviour, cancelled, catalogue, centre, centres, colour, colours, defence, favour, fibre,
    fulfil, grey, honour, initialise, judgement, labelled, licence, litre, maximise, metre, metres, minimise, modelled,
    neighbour, normalise, normalised, optimise, organise, organised, programme, realise, recognise, recognised,
    recognises, signalled, standardised, summarise, towards, travelled, travelling
"""
"""Spellings that are not American."""
WORDS = (
    *(term for term in _replaced() if term not in ORDINARY),
    *(word.strip() for word in " ".join(f"{DIALECT}, {BRITISH}".split()).split(",")),
)
BANNED = re.compile(
    r"(?<![\w-])(" + "|".join(sorted(map(re.escape, WORDS), key=len, reverse=True)) + r")(?![\w-])", re.I
)
QUOTED = re.compile(r"`[^`]*`|\{[^}]*\}|“[^”]*”")
"""Not checked: names in code, fields of a message and quoted rules."""

PRIVATE = """
    air start, autocorrelation, Bayes factor, bootstrap, candidate, clean flight, covariance, covariate, credible,
    discrepancy, draws, ensemble, hyperparameter, hyperprior, kept, latent, leave-one-out, likelihood, linearized,
    marginal, Monte Carlo, nuisance, parser, plain model, pooling, posterior, propellant_share, quantile, random effect,
    regression, shrinkage, sigma, spike and slab, stacking, tilt, variance, whitening
"""
"""Words of statisticians and developers that a flyer has not met."""
MOST_PRIVATE = 5
"""Highest number of such words that a flyer may meet and the glossary of the manual lacks. [1]"""

QUOTES = {
    "masses not on record": "a key in the shipped catalog of motors",
    "Me,X1,colour,,red,sure,a letter": "a row of corrections with an unknown column",
    "meter meters metre metres mtr metro metros mètre mètres metri м": "names of a unit in the headers of tables",
}
"""Whole texts that may hold a banned word, each with its reason: at most ten."""


def _python_texts(file: Path) -> Iterator[tuple[int, str]]:
    """Comments and strings of more than one word, docstrings among them, with their first lines."""
    source = file.read_text(encoding="utf-8")
    for token in tokenize.generate_tokens(io.StringIO(source).readline) if "#" in source else ():
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.search(r"\w\s+\w", node.value):
            yield node.lineno, node.value


@cache
def _texts() -> tuple[tuple[str, int, str], ...]:
    """Everything that is read: the file, a line, and the text."""
    return tuple(_read())


def _read() -> Iterator[tuple[str, int, str]]:
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            if name not in THIS and not name.startswith(MIGRATIONS):
                yield from ((name, line, text) for line, text in _python_texts(file))
    data = [file for kind in ("toml", "md", "html") for file in sorted((ROOT / "fieldkit").rglob(f"*.{kind}"))]
    data += [ROOT / "bench/README.md", ROOT / "bench/faults/page.md"]
    for page in (ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md")), *data):
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


def test_names_of_tests_hold_no_word_that_the_glossary_replaces() -> None:
    found = [
        f"{file.relative_to(ROOT)}:{node.lineno}: {node.name}"
        for file in sorted((ROOT / "tests").rglob("test_*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name.startswith("test_")
        if banned_words(node.name.replace("_", " "))
    ]
    assert not found, "\n".join(found)


def test_few_lines_are_excepted_and_each_has_a_reason() -> None:
    assert len(QUOTES) <= 10
    assert all(QUOTES.values())
    texts = {text for _, _, text in _texts()}
    assert [quote for quote in QUOTES if quote not in texts] == []


def test_the_whole_left_column_of_the_glossary_is_looked_for_or_has_an_ordinary_use() -> None:
    terms = _replaced()
    assert len(terms) > 80
    assert [term for term in ORDINARY if term not in terms] == []
    assert all(ORDINARY.values())
    assert banned_words(" and ".join(set(terms) - set(ORDINARY))) != []
    assert [term for term in terms if term not in ORDINARY and not banned_words(term)] == []


def test_a_flyer_meets_few_private_words_that_the_glossary_lacks() -> None:
    """On the pages before those on what was measured, among them the help of all commands, and in app and reports."""
    pages = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("What was measured")[0]
    files = [f"docs/{name}.md" for name in [*re.findall(r"- ([\w-]+)\.md", pages), "evidence"]] + ["README.md"]
    assert len(files) > 30
    shown = [re.sub(r"\]\([^)]*\)", "]", (ROOT / name).read_text(encoding="utf-8")) for name in files]
    shown += [text for _, _, text in texts(("fieldkit/tui", "fieldkit/presentation"))]
    private = [word.strip() for word in " ".join(PRIVATE.split()).split(",")]
    found = re.findall(rf"(?<![\w-])({'|'.join(map(re.escape, private))})s?(?![\w-])", "\n".join(shown), re.IGNORECASE)
    glossary = (ROOT / "docs/glossary.md").read_text(encoding="utf-8").lower()
    missing = {word.lower() for word in found if f"**{word.lower()}" not in glossary}
    assert len(missing) <= MOST_PRIVATE, sorted(missing)
    assert missing, "the words are looked for"
