"""Names are meaningful: no words that the glossary replaces, no duplicate type name, no constant that is a bare
adjective."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SHIPPED = ("fieldkit", "parsers", "models", "studies")
FOLDERS = (*SHIPPED, "bench", "tools", "tests")


def _set(text: str) -> frozenset[str]:
    return frozenset(text.split())


BANNED = _set(
    """
    afresh alike anew apart arrival arrivals askew begun crowd desk evened farewell fitting foretell foretells foretold
    hopeless intake intakes kept lean leans learnt luck lucks lucky oddities overheard overhears railed reflown rough
    roughly said seldom shelf shelves steady surer talk taught teach teaches tell telling tells testify testimony
    thinning tilt told took turns unlike untold wander wanders warmth witness woken
    """
)
"""Words of the left column of `docs/words.md` that have no ordinary meaning as part of a name here."""

BARE = _set(
    """
    ABANDONED ABOVE ABSENT AFTER ALIKE ALL ALLOWED ALONE ALWAYS ANNOUNCED APART AROUND ASKED AVERAGED BEFORE BEHIND
    BESIDE BETTER BETWEEN BEYOND BINARY BLANK BLIND BLURRED BURNING CALM CERTAIN CERTIFIED CHANGED CHECKED CLASSIC
    CLIPPED CLOSE COARSE COASTING COLDEST COMPLETED COUNTED CREDIBLE DECISIVE DECLARED DEEPEST DERIVED DIFFERENT
    DISTURBED DOWN DRAWN DRILLABLE DUE EACH EARLIER EARLY EDITED EMPTY ENDLESS ENOUGH ERASED EVEN EVERY EVERYWHERE FAINT
    FARTHEST FAST FASTEST FEW FEWEST FINE FIRST FITTED FLAT FLATTER FLOWN FOLLOWED FORETOLD FREE FULL FURTHEST FUSED
    GARBLED GOOD GROUPED GROWN HARD HARDEST HARDLY HEAVIEST HERE HIDDEN HIGH HOPELESS HOT HOW HYDROSTATIC IMPOSSIBLE
    INFLATED INHERITED INTERPRETED JUDGED KEPT KNOWN LARGE LARGEST LAST LASTING LASTS LATE LATEST LEAST LEFT LIGHTEST
    LIKELY LOADABLE LONGER LONGEST LOW MANY MEANT MIXED MORE MOST MOSTLY MOVED MOVING NAMED NARROWEST NEAR NEAREST
    NEARLY NEEDED NEGLIGIBLE NEVER NEW NEWEST NOISY NONE NORMAL NOTHING OBSERVED OFTEN OLD OLDER OLDEST ORDINARY OTHER
    OTHERS OURS OWN PAST PLAIN PLAUSIBLE PLUGGED PUSHED QUIET RARE RAW READ RECEIVED RECORDED RENAMED RESTING RETRIED
    REVERSED RIGHT RISING ROOMY ROUNDED SAID SAME SAMPLED SCORED SEEN SELDOM SETTLED SEVERAL SHARPEST SHORT SHOWN SIGNED
    SIGNIFICANT SIMULATED SINCE SLANTED SLIMMEST SLOW SLOWEST SMALL SMALLER SMALLEST SMOOTHED SMOOTHLY SOFT SPARSE
    SPELLED SPOKEN STACKED STAGED STANDING STARTED STATED STATIC STEEPEST STIFFEST STILL STRICT STRONGEST SUDDEN SURE
    SURER SURPRISING SWAPPED SYNCHRONOUS TELLING THEN THINNED THINNEST TOGETHER TOLD TRANSONIC TRIED TYPED UNCHECKED
    UNSEEN UNSIGNED UNSURE UNTOLD UNUSUAL UP USED VERTICAL VITAL WEIGHED WEIGHTLESS WHITE WIDE WIDER WIDEST WITHIN
    WORKING WORST WORTH WRITING
    """
)
"""Superlatives, adjectives and adverbs that are not meaningful alone."""


Modules = dict[Path, ast.Module]


@pytest.fixture(scope="module")
def modules() -> Modules:
    """Every module by its path in the checkout, parsed."""
    files = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py"))
    return {file.relative_to(ROOT): ast.parse(file.read_text(encoding="utf-8")) for file in files}


def _constants(tree: ast.Module) -> Iterator[str]:
    for node in tree.body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        for target in targets:
            yield from (name.id for name in ast.walk(target) if isinstance(name, ast.Name))


def _names(file: Path, tree: ast.Module) -> Iterator[str]:
    """Public names of a module: itself, its constants, classes, functions, and the parameters of those."""
    yield file.stem
    yield from (name for name in _constants(tree) if not name.startswith("_"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield node.name
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith(("_", "test_")):
            yield node.name
            arguments = node.args
            extra = [one for one in (arguments.vararg, arguments.kwarg) if one]
            yield from (one.arg for one in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, *extra))


ORDINARY = {
    "fitting": "motors that fit",
    "kept": "rows that a filter leaves",
    "tilt": "of a rail, in degrees",
    "turns": "steps in which a climb turns into a fall",
    "tell_apart": "an argument of every effect file",
}
"""Words and names that variables may have, with what they mean there."""


def _variables(tree: ast.Module) -> Iterator[str]:
    """Everything that a module assigns or defines: local variables, private names, attributes, functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.id if isinstance(node, ast.Name) else node.attr
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith("test_"):
            yield node.name


def _words(name: str) -> set[str]:
    """The words of a name in snake or camel case, in lower case."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)}


@pytest.mark.parametrize(
    ("name", "words"),
    [("fly_alike", {"fly", "alike"}), ("BesideFlights", {"beside", "flights"}), ("MOST_TOLD", {"most", "told"})],
)
def test_a_name_is_split_into_words(name: str, words: set[str]) -> None:
    assert _words(name) == words


def test_names_hold_no_word_that_the_glossary_replaces(modules: Modules) -> None:
    found = [
        f"{file}: {name}" for file, tree in modules.items() for name in _names(file, tree) if _words(name) & BANNED
    ]
    assert not found, "\n".join(found)


@pytest.mark.thorough
def test_variables_hold_no_word_that_the_glossary_replaces(modules: Modules) -> None:
    found = {
        f"{file}: {name}"
        for file, tree in modules.items()
        for name in _variables(tree)
        if name not in ORDINARY and _words(name) & BANNED - ORDINARY.keys()
    }
    assert not found, "\n".join(sorted(found))


def test_the_glossary_says_what_to_write_for_every_banned_word() -> None:
    rows = [line for line in (ROOT / "docs/words.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    left = " ".join(row.split("|")[1] for row in rows)
    assert set(re.findall(r"[a-z]+", left)) >= BANNED


def _types(tree: ast.Module) -> Iterator[str]:
    """Names of the classes of a module, and of its aliases of types; type variables are no types."""
    yield from (node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    for node in tree.body:
        match node:
            case ast.Assign(value=ast.Call(func=ast.Name(id="TypeVar"))):
                pass
            case ast.Assign(targets=[ast.Name(id=name)]) if re.match("_?[A-Z][a-z]", name):
                yield name


def test_classes_and_aliases_are_types() -> None:
    source = "class A:\n    class Inner: pass\nHeights = dict[str, float]\nKind = TypeVar('Kind')\nMOST = 3"
    assert list(_types(ast.parse(source))) == ["A", "Inner", "Heights"]


def test_no_type_name_occurs_twice(modules: Modules) -> None:
    """Migrations stay as they were released."""
    counts = Counter(
        name
        for file, tree in modules.items()
        if file.parts[0] in SHIPPED and "migrations" not in file.parts
        for name in _types(tree)
    )
    assert [name for name, count in counts.items() if count > 1] == []


def test_no_constant_is_a_bare_superlative_or_adjective(modules: Modules) -> None:
    found = [
        f"{file}: {name}"
        for file, tree in modules.items()
        for name in _constants(tree)
        if file.parts[0] in SHIPPED and name.lstrip("_") in BARE
    ]
    assert found == []
