"""The columns of a table are chosen in a form, and saved mappings are edited in the same form."""

from pathlib import Path

import pytest
from textual.content import Content
from textual.pilot import Pilot
from textual.widgets import Input, Static

from fieldkit.flight import Flight
from fieldkit.importing import ColumnChoice
from fieldkit.importing.tables.mapping import remember, remembered
from fieldkit.ledger import Ledger
from fieldkit.tui.widgets.table import Table
from tests.importing.test_rejections_name_the_file import BROKEN, SAVED
from tests.pressing import ROOT, at_home, opened, press, shown, text_of, typed, words

pytestmark = pytest.mark.fast
LOG = "".join(f"{n * 50},{n * 3},{20 + n}\n" for n in range(9))


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return at_home(tmp_path, monkeypatch)


async def test_a_column_and_its_unit_are_chosen_by_arrows_beside_the_first_rows(file: Path) -> None:
    (file.parent / "odd.csv").write_text("tick,howhigh,warmth\n" + LOG)
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")
        await press(pilot)
        await press(pilot, "m")
        await press(pilot, "ctrl+u", "t", "down", "enter")  # the only column that begins with t
        assert "tick [ms]" in shown(pilot)
        await press(pilot, "down", "down", "enter")
        assert "0, 50, 100" in shown(pilot)
        await press(pilot, "ctrl+u", *typed("how"), "down", "enter", "down", "enter")
        assert "howhigh [m]" in shown(pilot)
        await press(pilot, "ctrl+s")
        assert pilot.app.screen._reading.columns == ("time=tick [ms]", "altitude=howhigh [m]")


async def test_a_mistake_in_the_columns_is_named_and_corrected_where_it_was_typed(file: Path) -> None:
    (file.parent / "odd.csv").write_text("tick,howhigh,warmth\n" + LOG)
    async with opened(file, (80, 24), page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")
        await press(pilot)
        await press(pilot, "m", "ctrl+u", *typed("tick [ms]"), "down", *typed("tick [m]"), "ctrl+s")
        assert "found the column 'tick' for time and" in shown(pilot)
        await press(pilot, "m")
        assert [field.value for field in pilot.app.screen.query(Input)][:2] == ["tick [ms]", "tick [m]"]


async def test_the_import_page_says_beside_its_name_what_is_wrong_with_a_file(file: Path) -> None:
    for choice in SAVED:
        remember(choice)
    async with opened(file, (120, 36), page="import_files") as pilot:
        for number, what in enumerate(BROKEN):
            junk = file.parent / f"junk{number}.csv"
            junk.write_bytes(BROKEN[what])
            pilot.app.screen.go(file.parent, junk)
            await press(pilot)
            seen = shown(pilot)
            assert f"junk{number}.csv" in seen, what
            assert "found" in seen or "no parser" in seen, (what, seen)


async def test_a_note_does_not_repeat_the_name_of_its_file_whose_end_is_never_cut(file: Path) -> None:
    name = "a_cold_morning_at_the_field_of_2026.csv"
    (file.parent / name).write_bytes((ROOT / "sample_logs" / "rrc3__feet_and_commas.csv").read_bytes())
    async with opened(file, page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / name)
        await press(pilot)
        assert any("_of_2026.csv" in line.partition("│")[0] for line in shown(pilot).splitlines()[2:])
        assert shown(pilot).count(name) == 1
        assert "! has no units" in shown(pilot)


async def test_a_log_that_was_imported_with_a_rocket_is_known_without_it(file: Path) -> None:
    log = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(log.parent, log)
        await press(pilot)
        assert "already in the ledger" not in shown(pilot)
        await press(pilot, "enter", *typed("Astra"), "down", "down", *typed("F24-4W"), "ctrl+s", "_")
        assert "already in the ledger as a flight of Astra" in shown(pilot)


async def test_a_large_screen_shows_the_climb_in_a_log_and_how_a_file_was_read(file: Path) -> None:
    log = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
    (file.parent / "flights.csv").write_text("flight_id,rocket,motor,apogee_m\n1,Comet,C6-5,104\n")
    async with opened(file, (160, 50), page="import_files") as pilot:
        pilot.app.screen.go(log.parent, log)
        await press(pilot)
        assert "Height of flight-dd2afbb08f [m]" in shown(pilot)
        assert "487 used, 0 dropped" in text_of(pilot, "#how")
        await press(pilot, "N")
        assert "Height of flight-dd2afbb08f [ft]" in shown(pilot)
        pilot.app.screen.go(file.parent, file.parent / "flights.csv")
        await press(pilot)
        assert "Height of" not in shown(pilot)
        assert "How it was read" in shown(pilot)
    async with opened(file, page="import_files") as pilot:
        pilot.app.screen.go(log.parent, log)
        await press(pilot)
        assert "How it was read" not in shown(pilot)


async def test_the_setup_of_an_imported_log_follows_the_rocket_that_is_typed(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([Flight("77", "Comet", "X", "C6-5", dry_mass=0.1, diameter=0.03, apogee=100.0)])
    log = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(log.parent, log)
        await press(pilot)

        def answers() -> list[str]:
            names = ("rocket", "config", "motor", "dry_mass", "diameter")
            return [pilot.app.screen.query_one(f"#in-{name}", Input).value for name in names]

        async def answer(name: str, text: str) -> None:
            pilot.app.screen.set_focus(pilot.app.screen.query_one(f"#in-{name}", Input))
            await press(pilot, "ctrl+u", *typed(text), "_")

        await press(pilot, "enter", *typed("Astra"), "_")
        assert answers() == ["Astra", "B", "", "448 g", "66 mm"]
        await answer("motor", "F24-4W")
        await answer("dry_mass", "350")
        await answer("rocket", "Comet")
        assert answers() == ["Comet", "X", "F24-4W", "350", "30 mm"], "typed answers stay"
        await answer("rocket", "Nova")
        assert answers() == ["Nova", "", "F24-4W", "350", ""]
        await answer("rocket", "Astra")
        await press(pilot, "ctrl+s", "_")
    with Ledger.open(file) as ledger:
        (flight,) = [one for one in ledger.flights("Astra") if one.apogee and round(one.apogee, 1) == 162.8]
        assert (flight.config, flight.dry_mass, flight.diameter) == ("B", pytest.approx(0.35), 0.066)


async def test_a_saved_mapping_is_edited_in_the_same_form_and_forgotten(file: Path) -> None:
    remember(ColumnChoice({"time": "tick [ms]", "altitude": "warmth [m]"}, ("tick", "howhigh", "warmth")))
    async with opened(file, (80, 24), page="import_files") as pilot:
        await press(pilot, "M", "enter")
        assert "CHANNEL" not in shown(pilot)
        await press(pilot, "enter", "ctrl+u", *typed("how"), "down", "enter", "down", "down", "enter", "ctrl+s")
        assert remembered()[0].channels == {"time": "tick [ms]", "altitude": "howhigh [mm]"}
        await press(pilot, "x")
        assert not remembered()


async def test_a_column_that_names_its_unit_is_offered_no_other(file: Path) -> None:
    (file.parent / "odd.csv").write_text("tick (ms),howhigh [ft],warmth\n" + LOG)
    async with opened(file, page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")
        await press(pilot)
        await press(pilot, "m", "ctrl+u", "t", "i", "down", "enter")
        assert pilot.app.focused is not None
        assert pilot.app.focused.id == "in-altitude"


async def test_the_form_shows_the_table_and_which_columns_are_not_used_yet(file: Path) -> None:
    rows = "Nr;Rakete;Treibsatz;Hoehe\n1;Bird;C6-5;120\n2;Bird;D12-5;240\n"
    (file.parent / "mine.csv").write_text(rows)
    async with opened(file, page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "mine.csv")
        await press(pilot)
        await press(pilot, "m")
        seen = shown(pilot)
        for text in ("Nr  Rakete  Treibsatz  Hoehe", "1   Bird    C6-5       120", "2   Bird    D12-5      240"):
            assert text in seen
        for title in ("Rocket", "Motor", "Apogee"):
            assert title in seen, "without scrolling"
        muted = {part for part in text_parts(pilot) if part.strip() in ("Nr", "Rakete", "Treibsatz", "Hoehe")}
        assert [part.strip() for part in muted] == ["Rakete"]
        await press(pilot, "down", *typed("treib"), "down", "enter")
        assert "Treibsatz" in {part.strip() for part in text_parts(pilot)}


async def test_a_column_of_flights_without_a_unit_is_not_saved_before_one_is_chosen(file: Path) -> None:
    (file.parent / "odd.csv").write_text("Flug;Gipfel;Modell;Antrieb\n1;211;Lark;C6-5\n2;198;Lark;C6-5\n")
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")
        await press(pilot)
        await press(pilot, "m", *typed("Mod"), "enter", *typed("Antr"), "enter", *typed("Gipfel"), "ctrl+s")
        assert "Gipfel [ft]" in shown(pilot)
        await press(pilot, "down", "enter", "ctrl+s", "_")
        assert "apogee=Gipfel [m]" in pilot.app.screen._reading.columns
        assert "would add 2 flights" in words(pilot)


async def test_rows_without_a_unit_are_rejected_with_the_key_that_chooses_it_and_no_option(file: Path) -> None:
    (file.parent / "odd.csv").write_text("Flug;Gipfel;Modell;Antrieb\n1;211;Lark;C6-5\n2;198;Lark;C6-5\n")
    columns = {"rocket": "Modell", "motor": "Antrieb", "apogee": "Gipfel"}
    remember(ColumnChoice(columns, ("Flug", "Gipfel", "Modell", "Antrieb")))
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")
        await press(pilot)
        assert "2 rejected" in words(pilot)
        assert "or m to choose the unit of the column" in words(pilot)
        assert "--map" not in shown(pilot)


def text_parts(pilot: Pilot[None]) -> list[str]:
    """The muted parts of the table above the form."""
    content = pilot.app.screen.query_one("#table", Static).content
    assert isinstance(content, Content)
    return [content.plain[span.start : span.end] for span in content.spans if span.style == "$text-muted"]


async def test_a_folder_shows_what_is_in_it_and_an_unreadable_file_how_it_begins(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    day = tmp_path / "launch day"
    day.mkdir()
    (day / "first.csv").write_text("no,altimeter\nknows,this\n")
    (day / "blob.bin").write_bytes(b"a\0b" * 50)
    monkeypatch.chdir(tmp_path)
    async with opened(file, (160, 50), page="import_files") as pilot:
        pilot.app.screen.query_one("#files", Table).move_to(day)
        await press(pilot, "_")
        assert "In launch day blob.bin 150 B first.csv 24 B" in text_of(pilot, "#more")
        assert "Files that can be read" in text_of(pilot, "#more")
        await press(pilot, "enter", "_", "end", "_")
        assert "It begins no,altimeter knows,this" in text_of(pilot, "#more")
        await press(pilot, "up", "_")
        assert "It begins" not in text_of(pilot, "#more"), "not text"
