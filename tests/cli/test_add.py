"""Entering a flight: by answers, by options, interrupted, and going back."""

import io
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from datetime import datetime, timedelta, tzinfo
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.cli.prompts import Conversation, converse
from fieldkit.cli.session import MotorCheck
from fieldkit.flight import COLUMNS, READOUTS, TEXT_COLUMNS, Flight
from fieldkit.importing.manual_entry import QUESTIONS
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services import manual_entry
from fieldkit.services.manual_entry import DRAFT

CHECK_SHAPES = False

READ_OFF = ["923ft", "140 mph", "2.14", "7.9", "2.98", "5.6", "-.4", "905ft", "6.2", "48.3"]
ANSWERS = ["Astra", "A", "F24-4W", *READ_OFF, "", "322g", "66", "North field", "2", "71F", "calm"]
LAST = Flight(
    flight_id="7",
    rocket="Astra",
    config="A",
    motor="F24-4W",
    dry_mass=0.322,
    diameter=0.066,
    site="North field",
    apogee=281.3,
)


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "ledger.db"


Add = Callable[..., tuple[int, str, str]]


@pytest.fixture
def add(file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Add:
    """Runs `fieldkit add` with answers on a pipe; returns its status, output and messages."""

    def add(answers: Iterable[str] = (), *options: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{answer}\n" for answer in answers)))
        status = main(["--ledger", str(file), "add", *options])
        return status, *capsys.readouterr()

    return add


def flights_in(file: Path) -> list[Flight]:
    with Ledger.open(file) as ledger:
        return ledger.flights()


def person(ledger: Ledger, answers: Iterable[str], **state: object) -> tuple[Conversation, list[str]]:
    """A conversation with a user who gives these answers and then leaves; returns the questions."""
    asked: list[str] = []
    waiting = iter(answers)

    def listen(prompt: str) -> str | None:
        asked.append(prompt)
        return next(waiting, None)

    conversation = Conversation(ledger, listen, True, MotorCheck(), **state)
    converse(conversation)
    return conversation, asked


def test_a_flight_is_entered_from_first_to_last_question(add: Add, file: Path) -> None:
    status, out, err = add(ANSWERS)
    assert (status, err) == (0, "Saved flight 1. `fieldkit undo` to undo.\n")
    (flight,) = flights_in(file)
    assert (flight.rocket, flight.flight_id, flight.motor) == ("Astra", "1", "F24-4W")
    assert flight.apogee == pytest.approx(281.3304)
    assert flight.top_speed == pytest.approx(62.5856)
    assert flight.temperature == pytest.approx(294.82, abs=0.01)
    assert flight.apogee_to_eject == -0.4
    assert len(flight.readouts()) == 10
    assert (flight.site, flight.notes, flight.wind) == ("North field", "calm", 2.0)
    assert flight.date_time is not None
    assert "Apogee                281.3 m" in out


def test_readouts_are_asked_for_in_the_order_of_the_altimeter() -> None:
    asked = [question.name for question in QUESTIONS]
    assert asked[3:13] == [column.name for column in READOUTS]
    assert asked[:3] == ["rocket", "config", "motor"]


def test_an_empty_answer_is_not_recorded_and_never_zero(add: Add, file: Path) -> None:
    assert add(["Astra", "A", "F24-4W", "923ft", *[""] * 9])[0] == 0
    (flight,) = flights_in(file)
    assert flight.readouts().keys() == {"apogee"}
    assert flight.wind is None


def test_a_typing_error_in_the_third_field_is_asked_again_in_one_line(add: Add, file: Path) -> None:
    answers = [*ANSWERS]
    answers[2:3] = ["F24-4W "]
    answers[3:4] = ["9z3ft", "923 kg", "923ft"]
    status, _, err = add(answers)
    assert status == 0
    first, second, _ = err.splitlines()
    assert first.startswith("Apogee: found")
    assert second.startswith("Apogee: found the unit 'kg', expected one of m, mm")
    assert flights_in(file)[0].apogee == pytest.approx(281.3304)


def test_a_delay_that_cannot_be_read_is_noted(add: Add, file: Path) -> None:
    status, _, err = add([], "--rocket", "Astra", "--motor", "C6-R", "--dry-mass", "40g", "--apogee", "200m")
    assert status == 0
    assert "note: 'C6-R': found 'R' as the delay, expected seconds, or P for plugged" in " ".join(err.split())
    assert "found 'M' as the delay (4 to 10 s by the maker's letters), expected" in catalogue().doubt("H128W-M")
    assert flights_in(file)[0].delay is None


def test_an_unknown_motor_is_asked_for_again_with_the_nearest_names(add: Add, file: Path) -> None:
    status, _, err = add(["Astra", "A", "F2555", "?F24", "F24-4W", "281.3"])
    assert status == 0
    assert "did you mean" in err
    assert "AeroTech F24W, 24 mm" in err
    assert flights_in(file)[0].motor == "F24-4W"


def test_several_motors_are_accepted_and_tagged(add: Add, file: Path) -> None:
    status, _, err = add(["Astra", "A", "3xC6-5", "281.3", *[""] * 9, ""])
    assert status == 0
    assert "`cluster`" in err
    assert flights_in(file)[0].tags == ("cluster",)


def test_an_implausible_value_is_reported_and_accepted(add: Add, file: Path) -> None:
    answers = ["Astra", "A", "F24-4W", "3m", "100", "2.14", "2", "2.98", "", "", "50"]
    status, _, err = add(answers)
    assert status == 0
    assert "apogee 3 m is unusual" in err
    assert "check all three" in err
    assert "average acceleration 2.98 g is above peak acceleration 2 g" in err
    assert "ejection altitude 50 m is above apogee 3 m" in err
    assert flights_in(file)[0].eject_altitude == 50


def test_an_extra_digit_is_detected_from_earlier_flights(add: Add, file: Path) -> None:
    setup = ["--rocket", "Astra", "--motor"]
    for motor, apogee in (("F24-4W", "923ft"), ("F24-7W", "940ft"), ("E35-5W", "9230ft")):
        assert "times" not in add([], *setup, motor, "--apogee", apogee)[2]
    status, _, err = add([], *setup, "F24", "--apogee", "9230ft", "--coast-to-apogee", "5.1")
    assert status == 0
    assert "note: apogee 2813 m is 9.9 times the usual 284 m of this rocket and motor" in err
    assert "coast" not in err
    assert add(["Astra", "", "F24-4W", "60m"])[2].count("unusual: apogee 60 m is 21% of the usual") == 1
    assert len(flights_in(file)) == 5


def test_values_of_the_last_flight_are_offered(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([LAST])
        conversation, asked = person(ledger, ["", "", "", *READ_OFF, "", "", "", "", "", "", ""])
    assert asked[:3] == ["Rocket [Astra]: ", "Configuration [A]: ", "Motor [F24-4W]: "]
    assert "Dry mass (g) [322 g]: " in asked
    assert conversation.flight.with_changes(**conversation.flight.readouts()).dry_mass == pytest.approx(0.322)
    assert (conversation.flight.site, conversation.flight.diameter) == ("North field", pytest.approx(0.066))


def test_a_dash_leaves_a_field_empty_instead_of_the_offered_value(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([LAST])
        conversation, _ = person(ledger, ["", "-", "-", "100m", *[""] * 9, "-", "-"])
    assert (conversation.flight.config, conversation.flight.motor, conversation.flight.dry_mass) == ("", "", None)


def test_another_configuration_is_not_offered_the_mass_of_the_last_one(file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([LAST])
        _, asked = person(ledger, ["", "B", "", *[""] * 11])
    assert "Dry mass (g): " in asked


def test_back_returns_to_the_previous_field_and_offers_its_answer(file: Path) -> None:
    with Ledger.open(file) as ledger:
        conversation, asked = person(ledger, ["<", "Astra", "A", "<", "B", "F24-4W", "100m", "<", "110m"])
    assert asked[:2] == ["Rocket: ", "Rocket: "]
    assert asked[4] == "Configuration [A]: "
    assert "Apogee (m) [100m]: " in asked
    assert (conversation.flight.config, conversation.flight.apogee) == ("B", 110.0)


def test_a_user_may_correct_an_implausible_value_or_keep_it(file: Path) -> None:
    with Ledger.open(file) as ledger:
        conversation, asked = person(ledger, ["Astra", "", "F24-4W", "28000m", "280m", "800", ""])
    assert (conversation.flight.apogee, conversation.flight.top_speed) == (280.0, 800.0)
    assert asked.count("  Enter to accept it, or type it again: ") == 2


def test_the_unit_typed_last_is_the_default_of_the_next_value(file: Path) -> None:
    with Ledger.open(file) as ledger:
        answers = ["Astra", "A", "F24-4W", "923ft", *[""] * 6, "905", "14mph", "", "", "11.4oz", "2.6in"]
        conversation, asked = person(ledger, answers)
        assert "Ejection altitude (ft): " in asked
        assert conversation.flight.eject_altitude == pytest.approx(275.844)
        assert "Peak acceleration (g): " in asked
        assert conversation.flight.dry_mass == pytest.approx(0.3232, abs=1e-4)
        _, asked = person(ledger, ["Astra", "A", "F24-4W"], units=conversation.units)
    assert "Apogee (ft): " in asked


def test_a_question_mark_explains_the_field(add: Add) -> None:
    assert "Highest point above the pad." in add(["Astra", "A", "F24-4W", "?", "100"])[2]
    assert "so far Astra\n" in add(["?", "Astra", "A", "F24-4W", "100"])[2]


def test_answers_that_end_too_early_add_nothing(add: Add, file: Path) -> None:
    assert add([])[0] == 1
    status, _, err = add(["Astra", "A", "F24-4W"])
    assert status == 1
    assert "no readout" in err
    assert flights_in(file) == []


def test_every_column_is_an_option(add: Add, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERMINAL_WIDTH", "200")
    text = add([], "--help")[1]
    for header in {*TEXT_COLUMNS, *(column.header for column in COLUMNS)} - {"log"}:
        assert f"--{header.replace('_', '-')}" in text


def test_a_script_adds_a_flight_in_one_line_without_questions(add: Add, file: Path) -> None:
    options = ["--rocket", "Astra", "--motor", "F24-4W", "--apogee", "923ft", "--top-speed-mps", "62.6"]
    more = [
        "--flight-id",
        "x1",
        "--date-time",
        "2026-05-01T10:30",
        "--tags",
        "Weak launch;mine",
        "--wind-mps=2",
    ]
    assert add(["not", "an", "answer"], *options, *more)[0] == 0
    (flight,) = flights_in(file)
    assert (flight.flight_id, flight.tags, flight.wind) == ("x1", ("weak_launch", "mine"), 2.0)
    assert flight.date_time == datetime(2026, 5, 1, 10, 30)
    status, _, err = add([], *options, *more)
    assert (status, err) == (0, "Duplicate: it is already in the ledger\n")
    status, _, err = add([], *options, *more, "--apogee", "900ft")
    assert status == 1
    assert "fieldkit edit" in err


def test_a_flight_without_a_number_is_not_added_twice_unless_asked(add: Add, file: Path) -> None:
    options = ["--rocket", "Astra", "--motor", "F24-4W", "--apogee", "923ft", "--site", "Meadow", "--dry-mass", "322g"]
    dated = [*options, "--date-time", "2026-05-01T10:30"]
    for line, count in ((options, 1), (dated, 2)):
        assert add((), *line)[0] == 0
        status, _, err = add((), *line)
        assert (status, len(flights_in(file)), err.count("\n")) == (1, count, 1)
        (flight,) = (
            one for one in flights_in(file) if (one.date_time == datetime(2026, 5, 1, 10, 30)) is (line is dated)
        )
        assert f"flight {flight.flight_id} of {flight.date_time:%Y-%m-%d %H:%M} has the same values" in err
    for change in (("--apogee", "922ft"), ("--notes", "again"), ("--date-time", "2026-05-01T10:31")):
        assert add((), *dated, *change)[0] == 0
    assert add((), *options, "--again")[0] == 0
    assert len(flights_in(file)) == 6


EDITS: list[tuple[str, object]] = [
    ("apogee", 280.0),
    ("rocket", "Astra II"),
    ("dry_mass", 0.34),
    ("date_time", datetime(2020, 5, 1)),
    ("date_time", None),
    ("tags", ("spun",)),
]


@pytest.mark.sampled
@pytest.mark.parametrize(("column", "value"), EDITS)
@pytest.mark.parametrize("by_answers", [False, True])
def test_a_repeated_entry_is_recognized_after_the_flight_was_edited(
    add: Add, file: Path, column: str, value: object, by_answers: bool
) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([LAST])
    options = ("--rocket", "Astra", "--config", "A", "--motor", "F24-4W", "--apogee", "923ft")
    entry = (["Astra", "A", "F24-4W", "923ft"],) if by_answers else ((), *options)
    assert add(*entry)[0] == 0
    with Ledger.open(file) as ledger:
        ledger.edit("8", **{column: value})
    assert add(*entry)[0] == 1
    assert add((), *options, "--notes", "the second flight")[0] == 0


@pytest.mark.parametrize(("hours", "status"), [(1, 1), (25, 0)])
def test_a_repeated_entry_is_recognized_after_midnight(
    add: Add, hours: float, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    moment = datetime(2026, 5, 1, 23, 30)

    class Clock(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> datetime:  # type: ignore[override]
            return moment.replace(tzinfo=tz)

    monkeypatch.setattr(manual_entry, "datetime", Clock)
    options = ["--rocket", "Astra", "--motor", "F24-4W", "--apogee", "923ft", "--dry-mass", "322g"]
    assert add((), *options)[0] == 0
    moment += timedelta(hours=hours)
    assert add((), *options)[0] == status


def test_the_flight_of_another_day_may_have_the_same_values(add: Add, file: Path) -> None:
    options = ["--rocket", "Astra", "--motor", "F24-4W", "--apogee", "923ft", "--dry-mass", "322g"]
    assert add((), *options, "--date-time", "2020-05-01T10:30")[0] == 0
    assert add((), *options)[0] == 0


def test_answers_of_a_repeated_flight_stay_a_draft_until_it_is_asked_for_again(add: Add, file: Path) -> None:
    assert add(ANSWERS)[0] == 0
    assert add(ANSWERS)[0] == 1
    with Ledger.open(file) as ledger:
        assert ledger.draft(DRAFT)
    assert add((), "--resume", "--again")[0] == 0
    assert len(flights_in(file)) == 2


def test_a_script_uses_the_mass_and_diameter_of_the_last_flight(add: Add, file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.add([LAST, LAST.with_changes(flight_id="8", config="B", dry_mass=0.4, diameter=None, apogee=250.0)])
    status, _, err = add((), "--rocket", "Astra", "--config", "A", "--motor", "F24-4W", "--apogee", "270m")
    assert (status, flights_in(file)[-1].dry_mass, flights_in(file)[-1].diameter) == (0, 0.322, 0.066)
    assert "note: filled in dry mass 322 g, diameter 66 mm; change with --dry-mass and --diameter" in err
    for typed, kept in ((("--dry-mass", "330g"), 0.33), (("--dry-mass", "-"), None), (("--config", "C"), None)):
        status, _, err = add((), "--rocket", "Astra", "--config", "A", "--motor", "F24-4W", "--apogee", "271m", *typed)
        assert (status, flights_in(file)[-1].dry_mass, flights_in(file)[-1].diameter) == (0, kept, 0.066)
        assert ("is excluded from every fit" in err) is (kept is None)


@pytest.mark.parametrize(
    ("options", "found"),
    [
        (["--apogee", "100"], "rocket: found nothing"),
        (["--rocket", "Astra", "--motor", "ZZ99", "--apogee", "100"], "motor: no motor 'ZZ99'"),
        (["--rocket", "Astra", "--apogee", "1oo"], "apogee: found"),
        (["--rocket", "Astra"], "no readout"),
    ],
)
def test_a_bad_option_is_named(add: Add, file: Path, options: list[str], found: str) -> None:
    status, _, err = add([], *options)
    assert status == 1
    assert found in err
    assert flights_in(file) == []


@pytest.mark.parametrize("typed", ["385 g with motor", "13.58oz with motor"])
def test_an_answer_weighed_with_the_motor_gives_the_dry_mass(add: Add, file: Path, typed: str) -> None:
    answers = [typed if answer == "322g" else answer for answer in ANSWERS]
    assert add(answers)[0] == 0
    with Ledger.open(file) as ledger:
        assert ledger.flights()[0].dry_mass == pytest.approx(0.322, abs=0.001)


def test_a_script_may_give_the_mass_ready_to_fly(add: Add, file: Path) -> None:
    flown = ["--rocket", "Astra", "--apogee", "250m"]
    status, _, printed = add((), *flown, "--motor", "F24-4W", "--lift-off-mass", "385g")
    assert (status, "note: dry mass 322 g, without F24-4W" in printed) == (0, True)
    with Ledger.open(file) as ledger:
        assert ledger.flights()[0].dry_mass == pytest.approx(0.322, abs=0.001)
    for wrong, why in (
        (["--motor", "F24-4W", "--lift-off-mass", "60g"], "expected more than the mass of 62.9 g of AeroTech F24W"),
        (["--lift-off-mass", "385g"], "no motor"),
        (["--motor", "F24-4W", "--lift-off-mass", "385g", "--dry-mass", "322g"], "expected one of them"),
        (["--motor", "F24-4W", "--lift-off-mass", "heavy"], "expected a number"),
    ):
        status, _, printed = add((), *flown, *wrong)
        assert status != 0
        assert why in printed


def test_a_lift_off_mass_in_a_draft_of_the_app_is_not_lost(add: Add, file: Path) -> None:
    with Ledger.open(file) as ledger:
        draft = {"rocket": "Astra", "motor": "F24-4W", "apogee": "250 m", "lift_off_mass": "385 g"}
        ledger.keep_draft(DRAFT, draft)
    assert add([""] * len(ANSWERS), "--resume")[0] == 0
    with Ledger.open(file) as ledger:
        assert ledger.flights()[0].dry_mass == pytest.approx(0.322, abs=0.001)


def test_a_script_leaves_a_users_draft_alone_unless_asked_to_continue(add: Add, file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.keep_draft(DRAFT, {"rocket": "Comet", "config": "B"})
    status, _, err = add(ANSWERS)
    assert (status, flights_in(file)[0].rocket) == (0, "Astra")
    assert "run `fieldkit add --resume` to continue it" in err
    assert add(["F24-4W", "923ft"], "--resume")[0] == 0
    assert {flight.rocket for flight in flights_in(file)} == {"Astra", "Comet"}
    with Ledger.open(file) as ledger:
        assert ledger.draft(DRAFT) is None


def test_questions_resume_at_the_first_unreadable_value_of_a_draft(add: Add, file: Path) -> None:
    with Ledger.open(file) as ledger:
        ledger.keep_draft(DRAFT, {"rocket": "Comet", "config": "B", "motor": "ZZ99", "apogee": "300m"})
    status, _, err = add(["F24-4W", ""], "--resume")
    assert status == 0
    assert "Motor: no motor 'ZZ99'" in err
    (flight,) = flights_in(file)
    assert (flight.motor, flight.apogee) == ("F24-4W", 300.0)


def converse_in_terminal(file: Path, answers: list[str], last_words: str) -> tuple[str, int]:
    """Run `fieldkit add` in a separate terminal and kill it when it prints these words; returns its output."""
    import pty

    controller, terminal = pty.openpty()
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", str(file), "add"]
    adding = subprocess.Popen(command, stdin=terminal, stdout=terminal, stderr=terminal, start_new_session=True)
    os.close(terminal)
    os.write(controller, "".join(f"{answer}\n" for answer in answers).encode())
    printed, deadline = "", time.monotonic() + 60
    while last_words not in printed and time.monotonic() < deadline:
        if select.select([controller], [], [], 0.1)[0]:
            printed += os.read(controller, 4096).decode()
    adding.kill()
    adding.wait()
    os.close(controller)
    return printed, adding.returncode


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_add_killed_at_the_fifth_prompt_offers_to_continue(file: Path) -> None:
    printed, _ = converse_in_terminal(file, ["si", "Astra", "A", "F24-4W", "923ft"], "Top speed (m/s): ")
    assert "Numbers can be shown in" in printed
    assert "Top speed (m/s): " in printed
    assert flights_in(file) == []
    printed, _ = converse_in_terminal(file, ["y"], "Top speed (m/s): ")
    assert "Numbers can be shown in" not in printed, "the units are asked for once"
    assert "A flight is unfinished (rocket Astra, config A, motor F24-4W, apogee 923ft)." in printed
    assert "Rocket" not in printed.split("[Y/n]")[1]


def test_a_saved_forecast_and_its_error_are_printed_once(
    add: Add, file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    build = ["--rocket", "Swift", "--motor", "C6-5", "--dry-mass", "60g", "--diameter", "25mm"]
    assert main(["--ledger", str(file), "predict", *build[:4], "--dry-mass", "60g", "--diameter", "25mm"]) == 0
    capsys.readouterr()
    _, shown, _ = add([], *build, "--apogee", "250m")
    assert shown.count("; flown ") == 1
    assert shown.lower().count("forecast") == 1
    assert "inside the 90% interval" in " ".join(shown.split()).replace("OUTSIDE", "inside")
    assert main(["--ledger", str(file), "predict", *build[:4], "--dry-mass", "60g", "--diameter", "25mm"]) == 0
    add([], *build[:2], "--motor", "B6-4", *build[4:], "--apogee", "120m")
    _, shown, _ = add([], *build, "--apogee", "251m")
    assert "The forecast was stale: flight 2 added since." in " ".join(shown.split())


def test_an_impossible_flight_is_reported_once(add: Add) -> None:
    build = ["--rocket", "Swift", "--motor", "C6-5", "--dry-mass", "60g", "--diameter", "25mm"]
    add([], *build, "--apogee", "250m")
    _, _, messages = add([], *build, "--apogee", "9000m")
    assert messages.count("is excluded from every fit") == 1
