"""Choosing a parser, and rules that hold for every log."""

import pytest

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.flight.short_name import short_name
from fieldkit.importing import Note, Parser, Reading, recognize
from fieldkit.importing.read import read, read_plans, read_together
from fieldkit.importing.recognize import parser_for, parsers
from fieldkit.importing.to_flights import derived_id
from fieldkit.plugins import plugins, trained_folder
from tests.samples import SAMPLES, any_motor

pytestmark = pytest.mark.fast

LAUNCHES = next(sample for sample in SAMPLES if sample.name.startswith("altimetertwo_journal__a_season"))
ROCKETS = next(sample for sample in SAMPLES if sample.name.startswith("altimetertwo_journal__the_rockets"))


def test_plug_ins_are_in_alphabetical_order() -> None:
    assert list(parsers()) == sorted(parsers())
    assert {"flight_table", "altimetertwo_journal"} <= set(parsers())


def test_a_plug_in_that_binds_no_parser_is_an_internal_error() -> None:
    with pytest.raises(AttributeError, match="NOBODY_BINDS_THIS"):
        plugins("parsers", "NOBODY_BINDS_THIS")


def test_an_unknown_ensemble_is_refused_by_name() -> None:
    with pytest.raises(Exception, match="no trained ensemble is called 'none_such'"):
        trained_folder("none_such")


@pytest.mark.parametrize("log", [bytes(range(256)) * 64, b"", b"\0" * 100, b"\xff\xd8\xff\xe0JFIF", b"a,b\n1,2\n"])
def test_an_unrecognized_file_is_not_near_any_format(log: bytes) -> None:
    with pytest.raises(
        UnknownFormat, match=r"^junk\.csv: no parser recognizes this file, and no known format is similar$"
    ):
        read(log, "junk.csv", any_motor)


def test_an_unknown_format_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownFormat, match=r"no format 'xls', expected one of: .*altimetertwo_journal"):
        parser_for(b"", format="xls")


def test_an_unknown_motor_rejects_only_its_row() -> None:
    table = b"flight_id,rocket,motor,apogee_m\n1,Swift,C6-5,200\n2,Swift,ZZ99-1,210\n"
    imported = read(table, "t.csv", any_motor)
    assert [flight.flight_id for flight in imported.flights] == ["1"]
    (rejected,) = imported.rejected
    assert (rejected.file, rejected.row, rejected.column) == ("t.csv", 3, "motor")


def test_several_motors_at_once_are_not_looked_up() -> None:
    table = b"flight_id,rocket,motor,apogee_m,tags\n1,Swift,ZZ99-1,200,cluster\n"
    assert len(read(table, "t.csv", any_motor).flights) == 1


def test_a_flight_without_a_name_gets_the_same_one_in_any_unit_and_order() -> None:
    feet = b"rocket,motor,date_time,apogee_ft,notes\nSwift,C6-5,2026-05-01,1000,windy\n"
    metres = b"apogee_m;motor;date_time;rocket;tags\n304,8;C6-5;2026-05-01;Swift;\n"
    (one,), (other,) = read(feet, "a", any_motor).flights, read(metres, "b", any_motor).flights
    assert one.flight_id == other.flight_id == derived_id(one)
    assert one.flight_id.startswith("2026-05-01-")
    (third,) = read(feet.replace(b"1000", b"1001"), "a", any_motor).flights
    assert third.flight_id != one.flight_id


def test_a_flight_without_a_name_is_called_by_its_day_and_motor() -> None:
    table = (
        b"rocket,motor,date_time,apogee_m\nSwift,C6-5,2026-05-01,300\nSwift,C6-5,2026-05-01T10:30,300\nSwift,,,300\n"
    )
    by_day, by_time, by_nothing = read(table, "a", any_motor).flights
    assert short_name(by_day) == "2026-05-01 C6-5"
    assert short_name(by_time) == "2026-05-01 10:30 C6-5"
    assert short_name(by_nothing) == by_nothing.flight_id
    assert short_name(by_day.with_changes(flight_id="3")) == "3"


def test_names_and_masses_of_rockets_come_from_another_file() -> None:
    files = [(LAUNCHES.name, LAUNCHES.read_bytes()), (ROCKETS.name, ROCKETS.read_bytes())]
    launches, rockets = read_together(files, any_motor)
    named = {flight.flight_id: (flight.rocket, flight.dry_mass) for flight in launches.flights}
    assert named["2"] == ("Swift", pytest.approx(0.0364))
    assert named["4"] == ("Plover, 2nd", pytest.approx(0.151))
    assert named["5"] == ("3", None)
    assert not rockets.flights


def test_one_unusable_file_of_several_is_named() -> None:
    files = [(LAUNCHES.name, LAUNCHES.read_bytes()), ("photo.jpg", b"\xff\xd8\xff")]
    with pytest.raises(UnknownFormat, match=r"^photo\.jpg: "):
        read_together(files, any_motor)


def test_plans_are_in_order_and_without_readouts() -> None:
    header = b"flight_id,rocket,config,dry_mass_g,motor,wind_mps,apogee_m\n"
    table = header + b"p1,Astra,A,322,F24-4W,2,\n,Astra,B,448,F39,,99\n"
    first, second = read_plans(table, "plans.csv", any_motor)
    assert (first.flight_id, first.wind, first.dry_mass) == ("p1", 2, 0.322)
    assert (second.flight_id, second.readouts()) == ("row-3", {})


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (b"p,Astra,ZZ99-1,2", "plans.csv, row 2, Motor: found 'ZZ99-1'"),
        (b"p,Astra,,2", "plans.csv, row 2, motor: found nothing"),
        (b"p,Astra,F39,-2", "plans.csv, row 2, Wind_mps: found -2 m/s, expected 0 to 60 m/s"),
        (b"p,Astra,F39,two", "plans.csv, row 2, Wind_mps: found 'two'"),
    ],
)
def test_a_bad_plan_stops_the_table_and_its_row_is_named(row: bytes, message: str) -> None:
    with pytest.raises(DamagedLog, match=f"^{message}"):
        read_plans(b"flight_id,rocket,Motor,Wind_mps\n" + row + b"\n", "plans.csv", any_motor)


def test_contradictory_figures_are_reported_and_imported() -> None:
    table = b"flight_id,rocket,apogee_m,eject_altitude_m,top_speed_mps,avg_accel_g,burn_time_s,peak_accel_g\n"
    imported = read(table + b"1,Swift,71,93,37.6,2.1,8,2\n", "t.csv", any_motor)
    assert len(imported.flights) == 1
    assert [note.split(": ", 1)[0] for note in imported.notes] == ["t.csv, row 2"] * 3
    assert "ejection altitude 93 m is above apogee 71 m" in imported.notes[2]


def test_the_messages_of_a_parser_are_harmless_for_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    nasty = "\x1b[2J\u202e" + "x" * 9999 + "\nrow 2"
    found = [Note(nasty, row=1), DamagedLog(nasty, row=2, column=nasty), Reading({"apogee": 100.0})]
    monkeypatch.setattr(recognize, "parsers", lambda: {"rude": Parser("Rude", lambda head: True, lambda log: found)})
    imported = read(b"", "t", any_motor)
    lines = [*imported.notes, imported.rejected[0].error, imported.rejected[0].column or ""]
    assert all(len(line) < 2000 and line.isprintable() for line in lines)


def test_a_fallback_parser_is_used_if_no_other_claims_a_log(monkeypatch: pytest.MonkeyPatch) -> None:
    last = Parser("Last", lambda head: True, lambda log: [], fallback=True)
    known = {**parsers(), "last": last}
    monkeypatch.setattr(recognize, "parsers", lambda: known)
    assert parser_for(b"rocket,apogee_m\nSwift,100\n").title == "Flight table"
    assert parser_for(b"anything") is last


@pytest.mark.parametrize("name", ["flight_table", "fieldkit_json", "altimetertwo_journal"])
def test_an_endless_table_of_flights_is_refused_at_once(name: str) -> None:
    log = next(sample for sample in SAMPLES if sample.name.startswith(name)).read_bytes()
    with pytest.raises(DamagedLog, match="found 33 MB, expected at most 32 in a table of flights; split it"):
        read(log + b" " * (33 << 20), "t", any_motor, name)


@pytest.mark.parametrize(
    "log",
    [b"rocket,apogee_m\n" + b"1,\n" * 500_001, b'{"flights": [' + b"1," * 500_001 + b"1]}"],
    ids=["CSV", "JSON"],  # without them the log itself is the name of the test
)
def test_a_table_of_too_many_rows_is_refused_at_once(log: bytes) -> None:
    with pytest.raises(
        DamagedLog, match=r"found 500,00\d lines, expected at most 500,000 in a table of flights; split it"
    ):
        read(log, "t", any_motor)
