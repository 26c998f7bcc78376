"""A key has the same meaning on every page of the app."""

import re
from collections import defaultdict
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import pytest
from textual.binding import Binding

from fieldkit import tui
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.page import PageScreen, pages
from tools.strings import texts as texts_of

pytestmark = pytest.mark.fast

KINDS = ("b", "r", "x")
"""Keys with one label for different kinds of objects: select the next, reload, or remove what the page shows."""
FORM = "e"
"""The key that opens a form, named after what is entered there."""


def bindings() -> list[Binding]:
    """Every key of the app and of its screens, one at a time."""
    for module in walk_packages(tui.__path__, f"{tui.__name__}."):
        import_module(module.name)
    every = [binding for owner in (FieldkitApp, *_below(PageScreen)) for binding in owner.BINDINGS]
    return [one for binding in every if isinstance(binding, Binding) for one in _single(binding)]


def _below(screen: type[PageScreen]) -> list[type[PageScreen]]:
    return [screen, *(one for child in screen.__subclasses__() for one in _below(child))]


def _single(binding: Binding) -> list[Binding]:
    return [Binding(key, binding.action, binding.description) for key in binding.key.split(",")]


def test_a_key_has_one_meaning() -> None:
    """The same label and the same function: `p` plans the next flight and does not also edit a contest day."""
    meanings = defaultdict(set)
    for binding in bindings():
        if binding.key == "space" or (len(binding.key) == 1 and binding.key.isalpha()):
            meanings[binding.key].add((binding.description, binding.action.split("(")[0]))
    several = {key: actions for key, actions in meanings.items() if len(actions) > 1 and key not in (*KINDS, FORM)}
    assert several == {}
    assert all(len({word for word, _ in meanings[key]}) == 1 for key in KINDS)
    words = {word for word, _ in meanings[FORM]}
    assert len(words) == len({action for _, action in meanings[FORM]})
    assert "Edit" not in words, "the word names what is edited"
    assert len(meanings) > 20


def test_a_word_names_one_key() -> None:
    """One page had two words, Fly and Next; `Add` added flights, and kits by another key."""
    keys = defaultdict(set)
    for binding in bindings():
        if binding.description and len(binding.key) == 1:
            keys[binding.description].add(binding.key)
    assert {word: several for word, several in keys.items() if len(several) > 1} == {}
    titles = {page.title for page in pages().values()}
    assert {"Add", "Fly"} <= titles, "the words of the keys a and f"


def test_keys_that_change_the_model_are_capital_letters() -> None:
    keys = {binding.action: binding.key for binding in bindings()}
    assert keys["accept"] == "A"
    assert keys["decline"] == "D"


ROOT = Path(__file__).parents[2]
MENTIONED = re.compile(r"(?:\b[Pp]ress |[.;:,(] |^)([A-Za-z])(?= to [a-z])|\b[Pp]ress ([A-Za-z])\b")
"""A key in a sentence: `S to search`, `press e`."""
QUOTED = re.compile(r"`([A-Za-z0-9?]|F\d+|ctrl\+[a-z])`")
"""A key in the manual."""


def bound() -> set[str]:
    """Every key of the app and of its dialogs, as the manual writes it."""
    written = {"question_mark": "?", "f1": "F1"}
    return {written.get(one.key, one.key) for one in bindings()}


@pytest.mark.parametrize("page", ["app", "planning", "troubleshooting"])
def test_every_key_of_the_manual_exists(page: str) -> None:
    quoted = set(QUOTED.findall((ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")))
    assert quoted
    assert quoted - bound() == set()


def test_every_key_that_the_app_mentions_exists() -> None:
    texts = [text for name, _, text in texts_of(("fieldkit/tui", "fieldkit/presentation"))]
    found = {key for text in texts for pair in MENTIONED.findall(text) for key in pair if key}
    assert len(found) > 15
    assert found - bound() == set()
