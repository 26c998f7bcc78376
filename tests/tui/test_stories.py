"""What went wrong for flyers at the launch site, each as a story that must not repeat."""

import math
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, models
from fieldkit.services.close_loop import version_payload
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.manual_entry import usual
from fieldkit.services.one_offs import flights_beside_others
from fieldkit.settings import change_settings
from fieldkit.tui.next.intervals import HeightScale, IntervalBar, Intervals, bar
from fieldkit.tui.next.next_page import ForecastCard
from fieldkit.tui.widgets.big import GLYPHS, Big
from tests.pressing import ROOT, at_home, looked_at, opened, press, shown, text_of, typed, words

CHECK_SHAPES = False

LOG = "".join(f"{n * 50},{n * 3},{20 + n}\n" for n in range(9))


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return at_home(tmp_path, monkeypatch)


def notice(pilot: object) -> str:
    return text_of(pilot, "NoticeBar")  # type: ignore[arg-type]


async def test_a_column_mapping_belongs_to_the_file_for_which_it_was_typed(file: Path) -> None:
    (file.parent / "odd.csv").write_text("tick,howhigh,warmth\n" + LOG)
    (file.parent / "read.pf2").write_bytes((ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2").read_bytes())
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")  # type: ignore[attr-defined]
        await press(pilot)
        await press(pilot, "m", "ctrl+u", *typed("tick [ms]"), "down", "ctrl+u", *typed("howhigh [m]"), "ctrl+s", "_")
        assert "would add" in shown(pilot)
        pilot.app.screen.go(file.parent, file.parent / "read.pf2")  # type: ignore[attr-defined]
        await press(pilot, "_")
        assert "would add 1 flight" in " ".join(shown(pilot).split())
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")  # type: ignore[attr-defined]
        await press(pilot, "_")
        assert "would add" in shown(pilot), "the mapping is still there for its own file"


async def test_enter_takes_the_only_column_that_is_offered(file: Path) -> None:
    (file.parent / "odd.csv").write_text("tick,howhigh,warmth\n" + LOG)
    async with opened(file, (120, 36), page="import_files") as pilot:
        pilot.app.screen.go(file.parent, file.parent / "odd.csv")  # type: ignore[attr-defined]
        await press(pilot)
        await press(pilot, "m", "ctrl+u", *typed("tic"), "enter")
        assert pilot.app.screen.query_one("#in-time", Input).value == "tick"


async def test_an_unfinished_flight_of_another_build_names_the_open_forecast_and_yields_to_it(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    async with opened(file, page="add") as pilot:
        pilot.app.screen.query_one("#in-config", Input).focus()
        await press(pilot, "ctrl+u", *typed("A"), "enter", "_")
    with Ledger.open(file) as ledger:
        from fieldkit.motors import catalogue

        plan = Flight(rocket="Astra", config="B", motor="AeroTech F39T-6", dry_mass=0.448, diameter=0.066)
        predict_plans(ledger, catalogue(), [plan], save="plan")
    async with opened(file, page="add") as pilot:
        assert "^N to start the forecast's: Astra B on" in notice(pilot)
        await press(pilot, "ctrl+n", "_")
        assert pilot.app.screen.query_one("#in-config", Input).value == "B"


async def test_a_figure_that_is_not_final_is_marked_and_the_saved_one_is_the_one_shown(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "4", "_")
        card = pilot.app.screen.query_one(ForecastCard)
        table = pilot.app.screen.resting_place()  # type: ignore[attr-defined]
        exact = pilot.app.screen._motors.exact  # type: ignore[attr-defined]
        for _ in range(400):
            if exact:
                break
            await pilot.pause(0.05)  # until the cursor has rested
        await press(pilot)
        rows = {motor: table.cells(motor)[1] for motor in table.keys}
        assert exact == {table.current}
        assert all(text.startswith("≈") != (motor in exact) for motor, text in rows.items())
        assert "≈" not in card.text
        before = rows[table.current]
        await press(pilot, "enter", "_")
        assert f" to {before} m" in notice(pilot)
        await press(pilot, "d", *["right"] * 3, "_")  # the landing of the same plan
        assert before.split(".")[0] in shown(pilot)
    assert "≈" in GLYPHS


async def test_the_contest_shows_the_apogee_of_the_forecast(file: Path) -> None:
    from fieldkit.motors import Found, catalogue
    from fieldkit.planning.contest import rule_of
    from fieldkit.planning.forecasts import Plan, forecasts
    from fieldkit.planning.outlook import outlook
    from fieldkit.services.forecasts import rocket_of

    motors = catalogue()
    with Ledger.open(file) as ledger:
        rocket = rocket_of(ledger, motors, "Astra")
    plan = Flight(rocket="Astra", config="A", motor="AeroTech F24W", delay=4.0, dry_mass=0.322, diameter=0.066)
    found = Found(motors.resolve("AeroTech F24W").motor, None)
    (alone,) = forecasts(rocket, [(plan, found)])
    assert outlook(rule_of(2027), Plan(rocket, plan, found)).forecast.apogee_quantiles() == alone.apogee_quantiles()


async def test_units_chosen_later_win_over_one_typed_earlier(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("923ft"), "enter", "_")
        screen = pilot.app.screen
        assert screen._unit_of_answer(screen.field("eject_altitude").question) == "ft"  # type: ignore[attr-defined]
        await press(pilot, "escape", "N", "N", "N", "_")  # around to SI
        assert screen._unit_of_answer(screen.field("eject_altitude").question) == "m"  # type: ignore[attr-defined]
        assert screen.field("apogee").answer == "923ft"  # type: ignore[attr-defined]


async def test_escape_leaves_a_field_even_while_a_success_is_shown(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("92"), "ctrl+n", "_")
        assert "Started over" in notice(pilot)
        await press(pilot, "escape")
        assert not isinstance(pilot.app.focused, Input)


async def test_a_notice_of_success_expires_and_an_error_does_not(file: Path) -> None:
    async with opened(file) as pilot:
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr("fieldkit.tui.app.EXPIRY", 0.05)
            pilot.app.show_notice("Gone wrong", error=True)  # type: ignore[attr-defined]
            pilot.app.show_notice("Done")  # type: ignore[attr-defined]
            await pilot.pause(0.3)
        await press(pilot)
        assert [one.text for one in pilot.app.notices] == ["Gone wrong"]  # type: ignore[attr-defined]


async def test_the_plan_shows_the_mass_that_it_saves_when_its_configuration_changes(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "p", "_")
        form = pilot.app.screen
        assert form.query_one("#in-dry_mass", Input).value == "448 g"
        form.query_one("#in-config", Input).focus()
        await press(pilot, "ctrl+u", *typed("A"), "_")
        assert form.query_one("#in-dry_mass", Input).value == "322 g"
        await press(pilot, "ctrl+s", "_", "4", "_")
        assert "322 g dry" in shown(pilot)


async def test_a_date_in_the_future_is_asked_about(file: Path) -> None:
    ahead = f"{datetime.now() + timedelta(days=30):%Y-%m-%d}"
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("198"))
        pilot.app.screen.query_one("#in-date_time", Input).focus()
        await press(pilot, "ctrl+u", *typed(ahead), "ctrl+s", "_")
        assert "is in the future" in shown(pilot)


async def test_with_us_units_the_month_of_a_date_comes_first(file: Path) -> None:
    change_settings({"units": "US"}, file.with_name("settings.json"))
    async with opened(file, page="add") as pilot:
        pilot.app.screen.query_one("#in-date_time", Input).focus()
        await press(pilot, "ctrl+u", *typed("5/1/2026"), "_")
        assert pilot.app.screen._answered.flight.date_time == datetime(2026, 5, 1)  # type: ignore[attr-defined]
    change_settings({"units": "SI"}, file.with_name("settings.json"))
    async with opened(file, page="flights") as pilot:
        await press(pilot, "e", "_")
        pilot.app.screen.query_one("#in-date_time", Input).focus()
        await press(pilot, "ctrl+u", *typed("5/1/2026"), "_")
        assert "expected a date" in shown(pilot)


async def test_undo_asks_before_it_takes_back_an_import(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "u", "_")
        assert "12 flights" in words(pilot)
        await press(pilot, "n", "_")
        with Ledger.open(file) as ledger:
            assert len(ledger.flights()) == 12
        await press(pilot, "u", "_", "y", "_")
        with Ledger.open(file) as ledger:
            assert not ledger.flights()


async def test_undo_asks_before_it_takes_back_what_another_program_did(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot)
        with Ledger.open(file) as other:
            other.add([Flight("14", "Astra", "B", "F39T-6", dry_mass=0.448, apogee=199.0)], command="add")
        await press(pilot, "u", "_")
        assert "by another program: add 14" in words(pilot)
        await press(pilot, "escape", "_")
        with Ledger.open(file) as other:
            assert len(other.flights()) == 13


async def test_what_the_app_did_itself_is_undone_at_once(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        await press(pilot, *typed("198"), "ctrl+n", "_", "escape", "u", "_")
        assert "Undone: start over the unfinished flight" in notice(pilot)


def test_two_spellings_of_a_motor_are_one_motor(file: Path) -> None:
    from fieldkit.motors import catalogue

    with Ledger.open(file) as ledger:
        flown = usual(ledger, catalogue(), Flight(rocket="Astra", motor="F24-4W"))
        assert flown
        assert usual(ledger, catalogue(), Flight(rocket="Astra", motor="AeroTech F24W-7")) == flown


async def test_the_palette_opens_a_decision(file: Path) -> None:
    async with opened(file, (120, 36), page="home") as pilot:
        await press(pilot, "ctrl+p", "_")
        await press(pilot, *typed("decide: landing"), "_", "_")
        await press(pilot, "enter", "_")
        assert "Decide" in pilot.app.screen.TITLE  # type: ignore[operator]
        assert "wind" in shown(pilot)
        await press(pilot, "escape", "_", "ctrl+p", "_")
        await press(pilot, *typed("finals"), "_", "_")
        assert "Decide: finals" in shown(pilot)


def test_an_interval_that_is_not_finite_is_blank_and_ends_no_app() -> None:
    nothing = IntervalBar("weak", math.nan, math.nan, math.nan, math.nan)
    assert not bar(nothing, 0.0, 1.0, 20).strip()
    assert "weak" in str(Intervals((nothing, IntervalBar("good", 1.0, 2.0, 3.0)), lambda x: f"{x:g}", {}))
    scale = HeightScale.of([((math.nan, math.nan, math.nan), 100.0), (None, 200.0)], None)
    assert (scale.low, scale.high) == (100.0, 200.0)


async def test_a_flight_that_stands_out_is_tagged_with_its_likely_cause_by_one_key(file: Path) -> None:
    async with opened(file, (120, 36), page="loop") as pilot:
        off = r"Flight 4 flew \d\d% low: scatter, or with a chance of \d\d% extra drag"
        assert re.search(off, text_of(pilot, "#why"))
        assert shown(pilot).count("as the others") > 2, "flights that do not stand out are listed too"
        await press(pilot, "t", "_")
        assert "Tagged flight 4 extra_drag" in notice(pilot)
        assert re.search(r" 4 .* tagged +extra_drag", shown(pilot))
        assert "Tag it" not in shown(pilot)
    with Ledger.open(file) as ledger:
        assert ledger.flight("4").tags == ("extra_drag",)


async def test_what_rockets_share_is_shown_on_the_loop_page_after_a_fleet_search(file: Path) -> None:
    from fieldkit.services.fleet_findings import FLEET_DRAFT

    line = "AeroTech F24W since 2025-09-01: 24% less thrust and impulse than expected"
    with Ledger.open(file) as ledger:
        ledger.keep_draft(FLEET_DRAFT, {"lines": [line]})
    async with opened(file, page="loop") as pilot:
        assert line in words(pilot)


async def test_home_lists_tags_and_the_miss_of_every_flight_and_explains_the_selected_one(file: Path) -> None:
    async with opened(file, (160, 50), page="home") as pilot:
        rows = [line for line in shown(pilot).splitlines() if "Astra" in line and "04-18" in line]
        assert sum("~" in row for row in rows) == 11, "all but the one with a saved forecast"
        assert any("weak_launch" in row and "!~" in row for row in rows), "outside its interval"
        assert re.search("misses [▁-█]{12}", shown(pilot)), "as a trend beside the last flight"
        await press(pilot, "end", "_")
        assert "what the other flights lead to expect" in text_of(pilot, "#pane-facts")
        assert "Flight 1 flew" in text_of(pilot, "#pane-why")
        assert "Misses of Astra" in shown(pilot)
    async with opened(file, (120, 36), page="home") as pilot:
        assert not pilot.app.screen.query("Pane")


async def test_a_motor_with_an_open_forecast_is_listed_with_the_delay_of_that_forecast(tmp_path: Path) -> None:
    async with opened(tmp_path / "ledger.db", page="home") as pilot:
        await press(pilot, "enter", *typed("Lark"), "enter", *typed("100g"), "enter", *typed("35mm"), "enter")
        await press(pilot, *typed("c6-5"), "down", "enter", "_")
        assert "Lark on Estes C6-5" in shown(pilot)
        await press(pilot, "f", "_")
        assert "Lark on Estes C6-5" in shown(pilot), "although C6-3 fires nearer to apogee"
        await press(pilot, "d", "_")
        assert "Estes C6" in shown(pilot)
        await press(pilot, "escape", "u", "_", "u", "_")  # the forecast is taken back
        await press(pilot, "_")
        assert "C6-5" not in shown(pilot)


async def final_figure(pilot: Pilot[None]) -> str:
    """The apogee on the Fly page of the motor under the cursor, once its forecast is final."""
    for _ in range(400):
        await press(pilot)
        text = pilot.app.screen.query_one(ForecastCard).text
        if text and "≈" not in text:
            break
        await pilot.pause(0.05)  # until the cursor has rested
    found = re.search(r": ([\d.]+) m on the altimeter", text)
    assert found, text
    return found[1]


async def test_a_plan_has_one_apogee_on_all_pages(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(models, "now", lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    async with opened(file, (120, 36), page="next_flight") as pilot:
        figure = await final_figure(pilot)
        await press(pilot, "enter", "_")
        assert f" to {figure} m" in notice(pilot)
        await press(pilot, "d", "_", "right", "right", "_")
        contest = re.search(r"apogee (\d+) ft on the altimeter", text_of(pilot, "#answer"))
        assert contest
        assert float(contest[1]) * 0.3048 == pytest.approx(float(figure), abs=0.2)
        await press(pilot, "escape", "0", "_")
        assert pilot.app.screen.query_one("#next Big", Big).value == figure
        await press(pilot, "a", "_", *typed("198"), "ctrl+s", "_")
        assert f"Forecast {figure} m" in words(pilot)
        following = re.search(r"Next ([\d.]+) m", words(pilot))
        await press(pilot, "f", "_")
        assert following
        assert following[1] == await final_figure(pilot)


async def test_a_plan_fires_and_lands_at_one_time_on_all_pages(file: Path) -> None:
    """A charge before apogee ends the climb: on Fly it fired 0.8 s before the end of that, on Delay 2.3 s before the
    apogee without it. Contest and Landing had durations of their own draws."""
    async with opened(file, (120, 50), page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f24w"), "enter", "_")
        await final_figure(pilot)
        fires = re.search(r"ejection ([\d.]+ s (?:BEFORE|after)|at) apogee", words(pilot))
        assert fires
        by_delay = re.search(r"by delay ((?:\d+:[-+.\d]+ )+)s", words(pilot))
        assert by_delay
        assert fires[1].split()[0] in [one.split(":")[1].strip("+-") for one in by_delay[1].split()]
        await press(pilot, "d", "_")
        assert f"fires {fires[1]} apogee" in text_of(pilot, "#about")
        await press(pilot, "right", "right", "_")
        lands = re.search(r"duration ([\d.]+ s, 90% interval [\d.]+ to [\d.]+)", text_of(pilot, "#answer"))
        assert lands
        await press(pilot, "right", "_")
        assert f"duration {lands[1]}" in text_of(pilot, "#answer")


async def test_a_flight_missed_by_the_same_on_home_on_its_own_page_and_on_the_loop_page(file: Path) -> None:
    async with opened(file, (160, 50), page="home") as pilot:
        await press(pilot, "end", "_")
        missed = re.search(r"([\d.]+) m (above|below) what the other", text_of(pilot, "#pane-facts"))
        assert missed
        await press(pilot, "enter", "_")
        assert f"{missed[1]} m {'higher' if missed[2] == 'above' else 'lower'}" in text_of(pilot, "#forecast")


async def test_keys_pressed_while_the_pane_of_a_large_screen_opens_do_not_end_the_app(file: Path) -> None:
    async with opened(file, (160, 50), page="home") as pilot:
        screen = pilot.app.screen
        await screen.query_one("Pane").remove()
        for _ in range(3):
            screen._moved()  # type: ignore[attr-defined]  # before its widgets are there
        await press(pilot, "down", "_")
        assert "flown" in text_of(pilot, "#pane-facts")


async def test_home_and_the_loop_page_compare_the_flights_of_a_rocket_once(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared = []

    def counted(*args: object, **named: object) -> object:
        compared.append(args[2])
        return flights_beside_others(*args, **named)  # type: ignore[arg-type]  # as passed

    monkeypatch.setattr("fieldkit.services.one_offs.flights_beside_others", counted)
    async with opened(file, (160, 50), page="home") as pilot:
        await press(pilot, "5", "_", "0", "_")
        assert compared == ["Astra"]
        with Ledger.open(file) as other:
            other.edit("4", tags=["extra_drag"])
        await press(pilot, "5", "_", "f", "_", "0", "_")
        pilot.app.look_round()  # type: ignore[attr-defined]
        await press(pilot, "_")
        assert compared == ["Astra", "Astra"], "again after a change of the ledger"


async def test_what_rockets_share_is_on_home(file: Path) -> None:
    from fieldkit.services.fleet_findings import FLEET_DRAFT

    with Ledger.open(file) as ledger:
        ledger.keep_draft(FLEET_DRAFT, {"lines": ["AeroTech F24W: 24% less thrust and impulse than expected"]})
    async with opened(file, page="home") as pilot:
        assert "! AeroTech F24W: 24% less thrust" in shown(pilot)


async def test_safety_is_folded_to_what_fails_and_unfolded_by_a_key(file: Path) -> None:
    async with opened(file, (120, 36), page="next_flight") as pilot:
        await press(pilot, "d", "_")
        folded = text_of(pilot, "#beside")
        assert "not given" in folded
        assert "passed" in folded
        await press(pilot, "exclamation_mark")
        assert len(text_of(pilot, "#beside")) > len(folded)


async def test_the_button_that_saves_is_in_sight_on_a_large_screen(file: Path) -> None:
    async with opened(file, (160, 50), page="add") as pilot:
        assert pilot.app.screen.query_one("#save").region.bottom <= 48
        assert "Save this flight" in shown(pilot)


async def test_flights_and_home_list_the_same_misses(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        home = {line.split()[0]: re.search(r"!?~[+-][\d.]+", line) for line in shown(pilot).splitlines() if "~" in line}
        assert len(home) > 3
        await press(pilot, "1", "_")
        await pilot.pause(0.3)  # the cursor rests
        await press(pilot, "_")
        for id, miss in home.items():
            line = next(line for line in shown(pilot).splitlines() if line.split()[:1] in ([id], [f"▸{id}"]))
            assert miss
            assert miss[0] in line


@pytest.mark.parametrize("size", [(160, 50), (250, 70)])
async def test_a_decision_uses_both_halves_of_a_large_screen(file: Path, size: tuple[int, int]) -> None:
    async with opened(file, size) as pilot:
        await press(pilot, "f", "_", "d", "_")
        picture = pilot.app.screen.query_one("#picture").region
        assert picture.x > size[0] // 2 - 2
        assert picture.width > size[0] // 2 - 8
        assert picture.height > size[1] * 2 // 3


@pytest.mark.parametrize("size", [(80, 24), (120, 36), (160, 50)])
async def test_a_row_of_the_finals_is_one_line(file: Path, size: tuple[int, int]) -> None:
    async with opened(file, size, page="next_flight") as pilot:
        await press(pilot, "d", *["right"] * 7, "_")
        (heads,) = (line for line in shown(pilot).splitlines() if "target" in line and "lift-off" in line)
        assert "points" in heads


async def test_a_bar_of_a_score_is_beside_its_figure(file: Path) -> None:
    async with opened(file, (120, 36), page="next_flight") as pilot:
        await press(pilot, "d", *["right"] * 5, "_")
        bars = [line for line in shown(pilot).splitlines() if "█" in line and " m " in line]
        assert len(bars) == 6
        assert len([line for line in shown(pilot).splitlines() if line.strip().startswith("█" * 8)]) == 0


async def test_a_decision_names_its_conditions_in_brief_until_all_are_asked_for(file: Path) -> None:
    async with opened(file, (120, 36), page="next_flight") as pilot:
        await press(pilot, "d", "_")
        brief = text_of(pilot, "#under")
        assert "wind not given (from calm to 4.5 m/s the apogee falls by 4 to 9%), rail" in brief
        assert "lowers the apogee" not in brief
        await press(pilot, "exclamation_mark")
        assert "lowers the apogee" in text_of(pilot, "#under")


async def test_a_landing_without_a_wind_has_its_drift_drawn_against_the_wind(file: Path) -> None:
    async with opened(file, (120, 36), page="next_flight") as pilot:
        await press(pilot, "d", *["right"] * 3, "_")
        assert "Drift [m] by the wind [m/s]" in shown(pilot)


async def test_a_saved_flight_fills_the_page_with_its_plot(file: Path) -> None:
    async with opened(file, (120, 36), page="add") as pilot:
        await press(pilot, *typed("198"), "ctrl+s", "_")
        assert pilot.app.screen.query_one("AfterCard").region.height > 28
        assert pilot.app.screen.query_one("AfterCard .hill").region.height >= 10


@pytest.mark.parametrize(
    "keys",
    [("0",), ("1",), ("4",), ("4", "g", *typed("240m"), "enter"), ("4", "c"), ("5", "right"), ("6",), ("6", "right")],
    ids=" ".join,
)
async def test_no_row_is_cut_at_80_columns(file: Path, keys: tuple[str, ...]) -> None:
    async with opened(file, (80, 24), page="home") as pilot:
        for key in keys:
            await press(pilot, key, "_")
        assert "…" not in shown(pilot)


async def test_what_a_version_adds_is_never_cut(file: Path) -> None:
    wear = {"effect": "wear", "where": "", "since": "", "mean": 0.03, "sd": 0.01, "unit": "1"}
    several = [{**wear, "effect": name} for name in ("wear", "wind", "motor_thrust", "altimeter_scale")]
    sets = [{"probability": 0.25, "places": [one]} for one in several]
    with Ledger.open(file) as ledger:
        ledger.keep_version("Astra", version_payload(looked_at().diagnosis) | {"effects": several, "averaged": sets})
    async with opened(file, page="loop") as pilot:
        await press(pilot, "right", "right", "end", "_")
        adds = (
            "wear 25%, weathercocking in the wind 25%, a weak or strong motor 25%, an altimeter that reads high or low"
        )
        assert f"Version 1 adds {adds} 25%" in words(pilot)
