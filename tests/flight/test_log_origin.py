"""The origin of a flight's log, and who reads the texts of further columns."""

import ast
from dataclasses import fields
from pathlib import Path

from fieldkit.flight import Flight
from fieldkit.flight.log_origin import LogOrigin, log_origin

ROOT = Path(__file__).parents[2] / "fieldkit"
READERS = ("flight", "importing", "cli", "tui", "services/imports", "ledger/rows.py")
"""The record itself, and where texts come in, are merged column by column, or go out."""


def test_an_origin_is_read_back_as_it_was_recorded() -> None:
    texts = {f.name: f.name for f in fields(LogOrigin) if f.name not in ("kinds", "others")}
    whole = LogOrigin(**texts, kinds=("high", "low"), others=("ab12", "cd34"))
    for origin in (whole, LogOrigin(), LogOrigin("lark", device="Lark 1")):
        assert log_origin(origin.columns()) == origin
        assert Flight(extra={**origin.columns(), "Platz": "Süd"}).origin == origin
    assert LogOrigin().columns() == {}
    assert list(whole.columns()) == [
        "device",
        "firmware",
        "serial",
        "flight",
        "log_format",
        "log_kinds",
        "log_part",
        "other_logs",
    ]


def test_texts_of_further_columns_are_read_by_the_record_and_at_the_edges_only() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in sorted(ROOT.rglob("*.py"))
        if not path.relative_to(ROOT).as_posix().startswith(READERS)
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute) and node.attr == "extra"
    ]
    assert found == []
