"""Flight cards and reports of a day or a rocket: contents in every file format, and escaped names."""

import re
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue, FieldkitError, LedgerError
from fieldkit.flight import Flight
from fieldkit.importing import Reading
from fieldkit.importing.read import read_recordings
from fieldkit.ledger import Ledger, models
from fieldkit.motors import catalogue
from fieldkit.presentation.report import book as book_module
from fieldkit.presentation.report import card as card_module
from fieldkit.presentation.report import pictures
from fieldkit.presentation.report.book import FlightReport, book, table
from fieldkit.presentation.report.card import HeightTrace, cards
from fieldkit.presentation.report.paper import PER_PAGE, headline, pages, remarks
from fieldkit.presentation.report.style import A4, styled
from fieldkit.presentation.report.write import check_report, write_report
from fieldkit.safe_text import as_markdown
from fieldkit.services import inferred, replay
from fieldkit.services.forecasts import predict_plans
from tests.commands import Run
from tests.presentation.report.pages import Page
from tests.seasons import season

CHECK_SHAPES = False

HOSTILE = "<script>alert(1)</script> $x^2$ **b** [l](http://evil.example) | \u202eback\x1b[31m"
"""A rocket, site, tag or note from a file."""
FIRST = Flight(
    "1",
    HOSTILE,
    "A",
    "F24-4W",
    datetime(2026, 5, 2, 10, 30),
    site=HOSTILE,
    tags=("mine", HOSTILE),
    notes=HOSTILE,
    dry_mass=0.32,
    diameter=0.066,
    wind=2.0,
    apogee=250.0,
    top_speed=82.0,
)
SECOND = FIRST.with_changes(flight_id="2", date_time=datetime(2026, 5, 2, 11, 30), apogee=262.0, dry_mass=0.33)


def quiet(_what: str, _share: float) -> None:
    """Ignored progress."""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two flights of one day, the second predicted with another mass."""
    path = tmp_path_factory.mktemp("report") / "ledger.db"
    with Ledger.open(path) as ledger, pytest.MonkeyPatch.context() as patch:
        patch.setattr(models, "now", lambda: "2026-05-02T06:00:00+00:00")
        ledger.add([FIRST])
        plan = Flight("2", HOSTILE, "A", "F24-4W", dry_mass=0.32, diameter=0.066)
        predict_plans(ledger, catalogue(), [plan])
        ledger.add([SECOND])
    return path


@pytest.fixture(scope="module")
def day(file: Path) -> FlightReport:
    with Ledger.open(file) as ledger:
        return book(ledger, catalogue(), "2026-05-02", quiet)


def one(day: FlightReport) -> FlightReport:
    """The report of the second flight alone."""
    return FlightReport("Flight 2", "", day.cards[1:])


def test_a_report_can_be_for_a_day_a_flight_or_a_rocket(file: Path, day: FlightReport) -> None:
    assert (day.title, len(day.cards), day.summary) == ("Launch day 2026-05-02", 2, True)
    with Ledger.open(file) as ledger:
        flight = book(ledger, catalogue(), "2", quiet)
        with pytest.raises(LedgerError, match="no flight 'Lunar'"):
            book(ledger, catalogue(), "Lunar", quiet)
        feet = book(ledger, catalogue(), "2", quiet, "US")
    assert [card.id for card in flight.cards] == ["2"]
    assert not flight.summary
    assert ("Apogee", "860 ft") in feet.cards[0].readouts
    assert " m" not in " ".join(value for value, _ in headline(feet.cards[0]))


def test_a_card_has_figures_prediction_and_changes(day: FlightReport) -> None:
    first, second = day.cards
    assert first.forecast is not None
    assert not first.forecast.kept
    assert second.forecast is not None
    assert second.forecast.kept
    assert second.forecast.changes == ("dry mass was 320 g, now 330 g",)
    assert ("Apogee", "262.0 m") in second.readouts
    assert ("Dry mass", "330 g") in second.circumstances
    assert second.miss == pytest.approx(262.0 - second.forecast.interval[1])
    assert dict(headline(second))["262.0 m"] == "apogee"
    words = " ".join(remarks(second))
    assert "stale: dry mass was 320 g" in words
    assert "Drag coefficient Cd" in words
    assert second.record.tolist() == [250.0, 262.0]


@pytest.mark.thorough
def test_a_long_report_shows_the_loops_forecasts_rather_than_a_fit_for_each_flight(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(book_module, "MAX_FITS", 5)
    monkeypatch.setattr(card_module, "from_others", lambda *_: pytest.fail("a fit for a flight"))
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        flown = season(np.random.default_rng(3), ("apogee", "top_speed"), 6)
        ledger.add([one.with_changes(rocket="Astra", flight_id=str(n)) for n, (one, _) in enumerate(flown)])
        made = book(ledger, catalogue(), "Astra", quiet)
    expected = made.loops[0].diagnosis.forecasts_after.apogee
    shown = [one.forecast.interval[1] for one in made.cards if one.forecast]
    assert shown == pytest.approx(expected, rel=0.02)
    assert all("the loop forecasts" in one.forecast.by for one in made.cards if one.forecast)


def test_a_report_has_the_last_flights_and_counts_those_before(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(book_module, "MAX_FITS", 0)
    monkeypatch.setattr(card_module, "from_others", lambda *_: pytest.fail("a fit for a flight"))
    with Ledger.open(file) as ledger:
        made = book(ledger, catalogue(), "2026-05-02", quiet, last=1)
    assert ([card.id for card in made.cards], made.earlier) == (["2"], 1)
    assert made.subtitle.endswith("the latest 1 of 2 flights")
    assert main(["--ledger", str(file), "report", HOSTILE, "--last", "1", "--out", str(tmp_path / "a.md")]) == 0
    assert "note: without 1 earlier flight; --last 2 for all" in capsys.readouterr().err


def test_a_long_report_reads_a_table_once_and_infers_in_one_batch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    rows = [f"{n},Astra,F24-4W,{320 + n},66,{250 + n}" for n in range(12)]
    (tmp_path / "flights.csv").write_text("\n".join(["flight_id,rocket,motor,dry_mass_g,diameter_mm,apogee_m", *rows]))
    reads: list[Any] = []
    batches: list[int] = []
    read, infer = read_recordings, inferred.FlightInference.infer

    def counted_read(*given: Any) -> list[Reading]:
        reads.append(given)
        return read(*given)

    def counted_infer(self: inferred.FlightInference, flights: list[Flight]) -> inferred.Inferences:
        batches.append(len(flights))
        return infer(self, flights)

    monkeypatch.setattr(replay, "read_recordings", counted_read)
    monkeypatch.setattr(inferred.FlightInference, "infer", counted_infer)
    run("import", tmp_path / "flights.csv")
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        found = cards(ledger, catalogue(), ledger.flights("Astra"), quiet)
    assert (len(reads), batches) == (1, [12])
    assert [one.place for one in found] == list(range(12))
    assert all(one.learned and one.trace is None for one in found)


@pytest.mark.parametrize("top", [9.0, 400.0, 40_000.0])
def test_text_of_a_picture_stays_inside_its_margins(day: FlightReport, top: float) -> None:
    from matplotlib.figure import Figure

    time = np.linspace(0.0, 30.0, 50)
    height, speed = top * np.sin(time / 10), -top * np.cos(time / 10)
    card = replace(day.cards[0], trace=HeightTrace("Rook", time, height, speed, {"apogee": 15.7}))
    for draw, size, margins in (
        (pictures.forecast, (7.2, 2.2), pictures.FORECAST_MARGINS),
        (pictures.log, (7.2, 3.1), pictures.LOG_MARGINS),
    ):
        with styled():
            figure = Figure(figsize=size)
            draw(figure, card)
            pictures.fit(figure, margins)
            words = figure.get_tightbbox()
        assert words.x0 >= 0
        assert words.y0 >= 0
        assert words.x1 <= size[0]
        assert words.y1 <= size[1]


def test_the_table_shows_predictions_beside_flights(day: FlightReport) -> None:
    headers, rows = table(day)
    assert headers[5:8] == ("forecast m", "flown m", "miss m")
    assert rows[0][5] == ""
    assert rows[1][6] == "262.0"
    assert rows[1][8].startswith("stale forecast")
    assert {what: value for value, what in day.figures}["forecast"] == "1"


def test_names_from_files_are_text_in_html_and_pictures_are_inside(day: FlightReport, tmp_path: Path) -> None:
    (written,) = write_report(day, tmp_path / "day.html")
    html = written.read_text(encoding="utf-8")
    page = Page(html)
    assert not {"script", "a", "strong", "iframe"} & set(page.tags)
    words = " ".join(page.text)
    assert "<script>alert(1)</script>" in words
    assert "\u202e" not in html
    assert "\x1b" not in html
    assert "<U+202E>back␛[31m" in words
    assert len(page.sources) == 5
    assert all(source.startswith("data:image/svg+xml;base64,") for source in page.sources)


def test_names_from_files_are_text_in_markdown(day: FlightReport, tmp_path: Path) -> None:
    files = write_report(day, tmp_path / "day.md")
    text = files[-1].read_text(encoding="utf-8")
    assert "<script" not in text
    assert "](http" not in text
    assert "http:" not in text
    assert "**b**" not in text
    assert "\u202e" not in text
    assert "\x1b" not in text
    pictures = re.findall(r"!\[[^]]*\]\(<([^>]+)>\)", text)
    assert len(pictures) == 5
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in pictures)
    lines = [line for line in text.splitlines() if line.startswith("|")]
    cells = {len(re.findall(r"(?<!\\)\|", line)) for line in lines}
    assert cells == {3, 10}


@pytest.mark.parametrize(
    ("text", "safe"),
    [
        ("a|b", r"a\|b"),
        ("# big", r"\# big"),
        ("1. one", "1&#46; one"),
        ("`rm`", r"\`rm\`"),
        ("<b>&amp;", r"&lt;b\>&amp;amp;"),
        ("https://x.example", "http&#115;://x.example"),
        ("me@x.example", "me&#64;x.example"),
        ("- one", r"\- one"),
        ("---", r"\---"),
        ("-14.4", "-14.4"),
        ("3.2", "3.2"),
        ("F24-4W", "F24-4W"),
    ],
)
def test_markdown_syntax_is_escaped(text: str, safe: str) -> None:
    assert as_markdown(text) == safe


def test_each_card_is_one_a4_page(day: FlightReport, tmp_path: Path) -> None:
    with styled():
        sheets = list(pages(day))
    assert len(sheets) == 3
    assert {tuple(sheet.get_size_inches()) for sheet in sheets} == {A4}
    (pdf,) = write_report(one(day), tmp_path / "card.pdf")
    assert pdf.read_bytes().startswith(b"%PDF")
    assert pdf.read_bytes() == write_report(one(day), tmp_path / "again.pdf")[0].read_bytes()
    (png,) = write_report(one(day), tmp_path / "card.png")
    assert png.read_bytes().startswith(b"\x89PNG")


def test_many_flights_continue_over_pages(day: FlightReport) -> None:
    many = FlightReport("Astra", "", day.cards[:1] * (PER_PAGE + 1), summary=True)
    with styled():
        sheets = [page for page, _ in zip(pages(many), range(2), strict=False)]
    texts = [len(part.texts) for part in sheets[1].subfigs]
    assert sum(texts) > 10


def test_a_file_that_cannot_be_written_is_reported_in_one_line(day: FlightReport, tmp_path: Path) -> None:
    with pytest.raises(BadValue, match=r"found 'card\.doc'"):
        check_report(Path("card.doc"))
    with pytest.raises(FieldkitError, match="cannot be written"):
        write_report(FlightReport("", "", ()), tmp_path / "nowhere" / "card.html")


def test_the_command_writes_the_report(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "card.html"
    assert main(["--ledger", str(file), "report", "1", "--out", str(target)]) == 0
    assert "card.html" in capsys.readouterr().out
    assert "from 1 other normal flight it" in target.read_text(encoding="utf-8")
    assert main(["--ledger", str(file), "report", "1", "--out", str(tmp_path / "card.doc")]) == 1
    assert "card.doc" in capsys.readouterr().err
