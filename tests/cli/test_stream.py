"""Lists of any length are streamed in order and completely, as fast as they are read."""

import io
import json
import sys
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.cli import stream
from fieldkit.cli.main import main
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.ledger.tables import MAX_ROWS_BY_NAME

pytestmark = pytest.mark.fast
FIRST = datetime(2026, 5, 1, 10)
VALUES = st.none() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text()


@given(st.lists(st.dictionaries(st.text(), VALUES, min_size=1), max_size=4))
def test_a_streamed_document_equals_what_json_dumps_writes(documents: list[dict[str, object]]) -> None:
    out = io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", out)
        stream.stream_json("flights", documents)
    assert out.getvalue() == json.dumps({"flights": documents}, indent=2) + "\n"


def test_columns_grow_and_no_cell_is_cut_if_there_is_room(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    pages = [[("1", "Astra", "1 m")], [("2", "A much longer name 火箭", "10.5 m")], [("3", "", "2 m")]]
    stream.stream_table(("id", "rocket", "apogee"), pages, numbers=["apogee"])
    assert capsys.readouterr().out.splitlines() == [
        "id  rocket  apogee",
        "1   Astra      1 m",
        "2   A much longer name 火箭  10.5 m",
        "3                               2 m",
    ]


def test_in_a_narrow_terminal_the_widest_texts_are_cut(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "24")
    stream.stream_table(("id", "rocket", "apogee"), [[("1", "A much longer name \x1b[2J火箭", "10.5 m")]], ["apogee"])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(stream.cells, lines)) <= 24
    assert lines[1].startswith("1   A much long…")
    assert lines[1].endswith("10.5 m")


def flown(number: int) -> Flight:
    """Flights of three rockets, not in the order of entry, some without a date."""
    day = None if number % 7 == 3 else FIRST + timedelta(hours=(number * 37) % 400)
    tags = ("weak_launch",) if number % 5 == 0 else ()
    return Flight(flight_id=str(number // 3), rocket=f"R{number % 3}", date_time=day, tags=tags, apogee=100.0 + number)


@pytest.mark.parametrize("dated", [True, False])
def test_pages_are_the_flights_in_the_order_flown(tmp_path: Path, dated: bool) -> None:
    flights = [flown(number) for number in range(1300)]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([one for one in flights if one.date_time or not dated])
        for rocket, tag in ((None, None), ("R1", None), (None, "weak_launch"), ("R9", None)):
            expected = ledger.flights(rocket, tag=tag)
            pages = list(ledger.pages(rocket, tag))
            listed = [one for page in pages for one in page]
            assert [flight for _, flight in listed] == expected
            assert [id for id, _ in listed] == (ledger.ids(expected) if expected else [])
            assert all(len(page) <= MAX_ROWS_BY_NAME for page in pages)
            summaries = [one for page in ledger.summaries(rocket, tag) for one in page]
            assert [(one.id, one.rocket, one.motor, one.apogee, one.tags) for one in summaries] == [
                (id, flight.rocket, flight.motor, flight.apogee, flight.tags) for id, flight in listed
            ]
            days = [flight.date_time.date() if flight.date_time else None for flight in expected]
            assert [one.day for one in summaries] == days


def test_a_list_is_printed_before_its_last_page_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([flown(number) for number in range(1300)])
    printed: list[int] = []
    pages = Ledger.summaries

    def watched(*given: object, **named: object) -> object:
        for page in pages(*given, **named):  # type: ignore[arg-type]
            printed.append(capsys.readouterr().out.count("\n"))
            yield page

    monkeypatch.setattr(Ledger, "summaries", watched)
    assert main(["--ledger", str(file), "flights"]) == 0
    assert len(printed) == 4
    assert printed[0] == 0
    assert printed[1] == 101  # a heading and the first page
