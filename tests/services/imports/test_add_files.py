"""Importing files: a duplicate changes nothing, even if it would be read differently today."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from fieldkit.analysis import Recorded
from fieldkit.flight import Flight
from fieldkit.importing import from_samples
from fieldkit.ledger import Ledger, Renewal
from fieldkit.services.imports import Receipt, bring_in, remeasured
from tests.commands import Run
from tests.samples import SAMPLES, any_motor

pytestmark = pytest.mark.fast

PNUT = next(sample for sample in SAMPLES if sample.name.startswith("perfectflite__"))
KINDS = ("app__low", "app__high", "summary")
RAVEN = {name: next(s for s in SAMPLES if s.name.startswith(f"blueraven_{name}")) for name in KINDS}
ALTOS = {
    form: next(s for s in SAMPLES if s.name == name)
    for form, name in (
        ("csv", "altos_csv__with_satellites.csv"),
        ("flash", "altos_eeprom__telemetrum_2_old_form.eeprom"),
    )
}
TABLE = "flight_id,rocket,motor,apogee_m,log\n1,Astra,F24-4W,,{log}\n"


@pytest.fixture
def ledger(tmp_path: Path) -> Ledger:
    return Ledger.open(tmp_path / "ledger.db")


@pytest.fixture
def better_measuring(monkeypatch: pytest.MonkeyPatch) -> None:
    """A changed reader that gives an apogee one meter higher and another column."""
    as_it_was = from_samples.columns

    def better(recorded: Recorded, stated: dict[str, object]) -> tuple[dict[str, object], dict[str, str]]:
        fields, extra = as_it_was(recorded, stated)
        return {**fields, "apogee": fields["apogee"] + 1.0}, {**extra, "a_new_column": "1"}  # type: ignore[operator]

    return monkeypatch.setattr(from_samples, "columns", better)


def taken(ledger: Ledger, *paths: Path, **defaults: object) -> Receipt:
    return bring_in(ledger, paths, any_motor, defaults=defaults)


def test_a_log_that_would_be_measured_differently_today_is_a_duplicate(
    ledger: Ledger, request: pytest.FixtureRequest
) -> None:
    (id,) = taken(ledger, PNUT).ids
    ledger.edit(id, rocket="Astra")
    before = ledger.flights()
    request.getfixturevalue("better_measuring")
    again = taken(ledger, PNUT)
    assert (again.ids, again.duplicates, again.rejected) == ((), 1, ())
    assert ledger.flights() == before
    (rejected,) = taken(ledger, PNUT, rocket="Comet").rejected
    assert "this log is in the ledger as a flight of Astra" in rejected.error
    assert ledger.flights() == before


def test_options_for_a_duplicate_log_are_never_silently_ignored(ledger: Ledger) -> None:
    taken(ledger, PNUT, motor="F24-4W")
    (line,) = taken(ledger, PNUT, motor="G80-7T").rejected
    assert "another motor" in line.error


def test_a_row_whose_log_would_be_measured_differently_today_is_a_duplicate(
    ledger: Ledger, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    (tmp_path / PNUT.name).write_bytes(PNUT.read_bytes())
    table = tmp_path / "season.csv"
    table.write_text(TABLE.format(log=PNUT.name))
    taken(ledger, table)
    request.getfixturevalue("better_measuring")
    assert taken(ledger, table).duplicates == 1
    table.write_text(TABLE.format(log=PNUT.name).replace(",,", ",300,"))
    (line,) = taken(ledger, table).rejected
    assert "another apogee" in line.error


def test_every_file_of_a_logger_that_writes_several_is_kept(ledger: Ledger) -> None:
    low, high, _ = RAVEN.values()
    (id,) = taken(ledger, low, high).ids
    assert ledger.log(id) == low.read_bytes()
    assert ledger.other_logs(id) == [high.read_bytes()]
    assert taken(ledger, low, high).duplicates == taken(ledger, low).duplicates == 1


def test_for_a_single_file_it_is_noted_that_others_may_belong_to_it(ledger: Ledger) -> None:
    receipt = taken(ledger, RAVEN["app__low"])
    assert any("with it or after it to use them" in note for note in receipt.notes)


@pytest.mark.parametrize("order", [("app__low", "app__high", "summary"), ("summary", "app__high", "app__low")])
def test_files_imported_one_after_another_are_one_flight(ledger: Ledger, tmp_path: Path, order: tuple[str]) -> None:
    files = [RAVEN[name] for name in order]
    (id,) = taken(ledger, files[0]).ids
    for file in files[1:]:
        receipt = taken(ledger, file)
        assert (receipt.ids, receipt.joined, receipt.duplicates, receipt.rejected) == ((), (id,), 0, ())
    (flight,) = ledger.flights()
    assert (ledger.log(id), ledger.other_logs(id)) == (files[0].read_bytes(), [one.read_bytes() for one in files[1:]])
    with Ledger.open(tmp_path / "together.db") as other:
        taken(other, *files)
        (together,) = other.flights()
    assert flight.readouts() == together.readouts()
    where = {"other_logs", "log_format"}
    assert flight.extra.items() - together.extra.items() <= {(name, flight.extra.get(name)) for name in where}
    assert flight.extra["log_kinds"] == "high low summary"
    assert [taken(ledger, file).duplicates for file in files] == [1, 1, 1]
    assert taken(ledger, *files).duplicates == 1
    ledger.undo()
    assert ledger.flights()[0].extra["log_kinds"] == " ".join(sorted(kind_of(name) for name in order[:2]))


def kind_of(name: str) -> str:
    return name.removeprefix("app__")


@pytest.mark.parametrize("order", [("csv", "flash"), ("flash", "csv")])
@pytest.mark.parametrize("again", ["alone", "together"])
def test_the_flash_and_the_export_of_a_numbered_flight_are_one_flight(
    ledger: Ledger, order: tuple[str, str], again: str
) -> None:
    first, second = (ALTOS[form] for form in order)
    (id,) = taken(ledger, first).ids
    receipt = taken(ledger, *((second,) if again == "alone" else (first, second)))
    assert (receipt.ids, receipt.joined, receipt.rejected) == ((), (id,), ())
    assert (ledger.log(id), ledger.other_logs(id)) == (first.read_bytes(), [second.read_bytes()])
    assert [taken(ledger, file).duplicates for file in (first, second)] == [1, 1]
    assert taken(ledger, second, first).duplicates == 1
    assert len(ledger.flights()) == 1


def test_a_number_reused_after_erasing_the_memory_is_another_flight(ledger: Ledger, tmp_path: Path) -> None:
    (id,) = taken(ledger, ALTOS["csv"]).ids
    ledger.edit(id, apogee=700.0)
    receipt = taken(ledger, ALTOS["flash"])
    assert (len(receipt.ids), receipt.joined) == (1, ())
    assert any(f"may belong to flight {id}, which has the same number" in note for note in receipt.notes)


def test_another_export_of_a_numbered_flight_gets_a_note_on_what_it_may_be(ledger: Ledger, tmp_path: Path) -> None:
    (id,) = taken(ledger, ALTOS["csv"]).ids
    exported = tmp_path / "again.csv"
    exported.write_bytes(b"# Comment: exported once more\n" + ALTOS["csv"].read_bytes())
    receipt = taken(ledger, exported)
    assert (len(receipt.ids), receipt.joined) == (1, ())
    assert any(f"may belong to flight {id}, which has the same number" in note for note in receipt.notes)


def test_a_file_imported_later_keeps_what_the_flyer_typed(ledger: Ledger) -> None:
    (id,) = taken(ledger, RAVEN["app__low"]).ids
    ledger.edit(id, apogee=123.0, notes="windy", rocket="Astra")
    assert taken(ledger, RAVEN["app__high"], motor="F24-4W").joined == (id,)
    flight = ledger.flight(id)
    assert (flight.apogee, flight.notes, flight.rocket, flight.motor) == (123.0, "windy", "Astra", "F24-4W")
    assert "apogee" not in flight.sd
    assert flight.peak_accel is not None


def test_a_file_with_another_lift_off_time_is_another_flight(ledger: Ledger, tmp_path: Path) -> None:
    taken(ledger, RAVEN["app__low"])
    later = tmp_path / "later.csv"
    later.write_bytes(RAVEN["app__high"].read_bytes().replace(b",11:04:", b",12:04:"))
    receipt = taken(ledger, later)
    assert (len(receipt.ids), receipt.joined) == (1, ())
    assert not any("may belong to flight" in note for note in receipt.notes)


def test_a_file_without_a_time_of_day_gets_a_note_on_its_possible_flight(ledger: Ledger, tmp_path: Path) -> None:
    (id,) = taken(ledger, RAVEN["app__low"]).ids
    spoilt = tmp_path / "spoilt.csv"
    spoilt.write_bytes(RAVEN["app__high"].read_bytes().replace(b",11:04:", b",04:"))
    receipt = taken(ledger, spoilt)
    assert (len(receipt.ids), receipt.joined) == (1, ())
    assert any(f"may belong to flight {id}" in note for note in receipt.notes)


def test_remeasuring_files_keeps_typed_values(ledger: Ledger, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    (tmp_path / PNUT.name).write_bytes(PNUT.read_bytes())
    table = tmp_path / "season.csv"
    table.write_text(f"flight_id,rocket,apogee_m,burn_time_s,log\n1,Astra,,0.77,{PNUT.name}\n")
    taken(ledger, table)
    (id,) = taken(ledger, PNUT).ids
    before = {name: ledger.flight(name) for name in ("1", id)}
    ledger.edit(id, apogee=77.0)
    for name in before:
        again = remeasured(ledger, name)
        assert again is not None
        assert (again.changes, again.others) == ({}, ())
    request.getfixturevalue("better_measuring")
    again = remeasured(ledger, "1")
    assert again is not None
    assert again.changes == {"apogee": (before["1"].apogee, pytest.approx((before["1"].apogee or 0) + 1))}
    assert again.kept == ("burn_time",)
    assert again.others == ("a_new_column",)
    edited = remeasured(ledger, id)
    assert edited is not None
    assert (edited.changes, edited.kept) == ({}, ("apogee",))


def test_a_readout_edited_after_remeasuring_is_kept(ledger: Ledger, request: pytest.FixtureRequest) -> None:
    (id,) = taken(ledger, PNUT).ids
    ledger.edit(id, notes="windy")
    request.getfixturevalue("better_measuring")
    once = remeasured(ledger, id)
    assert once is not None
    assert ledger.renew([Renewal(id, once.flight, once.renewed, once.renewed_entered)]) == 1
    twice = remeasured(ledger, id)
    assert twice is not None
    assert (twice.changes, twice.others, twice.kept) == ({}, (), ())
    ledger.edit(id, apogee=77.0)
    edited = remeasured(ledger, id)
    assert edited is not None
    assert (edited.changes, edited.kept) == ({}, ("apogee",))
    assert ledger.flight(id).notes == "windy"
    assert taken(ledger, PNUT).duplicates == 1


def test_remeasure_lists_its_changes_makes_them_and_can_be_undone(
    ledger: Ledger, request: pytest.FixtureRequest, run: Run
) -> None:
    (id,) = taken(ledger, PNUT).ids
    ledger.add([Flight("typed", "Astra", apogee=200.0)])
    before = ledger.flight(id)
    request.getfixturevalue("better_measuring")

    lower = before.with_changes(apogee=(before.apogee or 0) - 2, sd=before.sd, source=before.source)
    ledger.renew([Renewal(id, before, lower)])
    assert f"`fieldkit remeasure {id} --dry-run`" in run("show", id).err
    ledger.undo()
    assert "1 would change, 0 unchanged, 1 without samples" in run("remeasure", "--dry-run").out
    assert ledger.flight(id) == before
    (entry,) = run("remeasure", id, "--json").document["flights"]
    apogee = entry["changes"]["apogee_m"]
    assert apogee["now"]["value"] - apogee["there"]["value"] == pytest.approx(1.0)
    assert apogee["now"]["sd"] == before.sd["apogee"]
    assert ledger.flight(id).apogee == pytest.approx((before.apogee or 0) + 1)
    assert "0 changed, 1 unchanged" in run("remeasure", id).out
    run("undo")
    assert ledger.flight(id) == before
    assert "±" in run("remeasure").out


def test_a_flight_far_from_the_others_is_named_if_another_rocket_has_its_number(ledger: Ledger, tmp_path: Path) -> None:
    rows = "".join(f"{n},Astra,F24-4W,{apogee}\n" for n, apogee in enumerate((240, 241, 239, 240, 600), start=1))
    (tmp_path / "table.csv").write_text(f"flight_id,rocket,motor,apogee_m\n{rows}")
    ledger.add([Flight("5", "Comet", motor="C6-5", apogee=100.0)])
    receipt = taken(ledger, tmp_path / "table.csv")
    assert "Astra/5" in receipt.ids
    assert any("flight 5 of Astra" in note for note in receipt.notes)


def test_remeasure_names_a_damaged_ledger_once(ledger: Ledger, tmp_path: Path, run: Run) -> None:
    ledger.add([Flight(str(number), "Astra", apogee=200.0) for number in range(9)])
    with closing(sqlite3.connect(tmp_path / "ledger.db")) as raw, raw:
        raw.execute("ALTER TABLE logs RENAME TO lost")
    assert run("remeasure", "--dry-run", status=1).err.count("the file is damaged") == 1


@pytest.mark.parametrize(
    ("cell", "correction", "changed"),
    [("852", "842", "apogee"), ("F42-8T", "F42T-8", "motor"), ("40.1", "", "duration")],
)
def test_a_row_corrected_in_a_table_without_numbers_is_noted(
    ledger: Ledger, tmp_path: Path, cell: str, correction: str, changed: str
) -> None:
    """Flights without numbers are identified by their figures, so the corrected row is a second flight."""
    table = tmp_path / "season.csv"
    table.write_text(
        "date,rocket,motor,dry_mass_g,apogee_ft,duration_s\n"
        "2026-09-05,Lark,F42-8T,520,852,40.1\n2026-09-05,Lark,F42-8T,522,846,39.6\n",
        encoding="utf-8",
    )
    first = bring_in(ledger, [table], any_motor)
    assert not any("differs" in note for note in first.notes)
    table.write_text(table.read_text(encoding="utf-8").replace(cell, correction, 1), encoding="utf-8")
    again = bring_in(ledger, [table], any_motor)
    assert (len(again.ids), again.duplicates) == (1, 1)
    (note,) = (note for note in again.notes if "differs" in note)
    assert f"only in {changed}; if it is a correction, remove {first.ids[0]}" in note
