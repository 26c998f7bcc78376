"""Files into the ledger: what was imported once changes nothing, however it would be read today."""

from pathlib import Path

import pytest

import fieldkit.recording
from fieldkit.flight import Flight
from fieldkit.intake import Receipt, bring_in
from fieldkit.ledger import Ledger
from fieldkit.recording import Recorded
from tests.samples import SAMPLES, any_motor

PNUT = next(sample for sample in SAMPLES if sample.name.startswith("perfectflite__"))
RAVEN = {name: next(s for s in SAMPLES if s.name.startswith(f"blueraven_{name}")) for name in ("app__low", "app__high")}
TABLE = "flight_id,rocket,motor,apogee_m,log\n1,Astra,F24-4W,,{log}\n"


@pytest.fixture
def ledger(tmp_path: Path) -> Ledger:
    return Ledger.open(tmp_path / "ledger.db")


@pytest.fixture
def better_measuring(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on an apogee is measured a metre higher, and another column tells of it."""
    as_it_was = fieldkit.recording.columns

    def better(recorded: Recorded, stated: dict[str, object]) -> tuple[dict[str, object], dict[str, str]]:
        fields, extra = as_it_was(recorded, stated)
        return {**fields, "apogee": fields["apogee"] + 1.0}, {**extra, "a_new_column": "1"}  # type: ignore[operator]

    return monkeypatch.setattr(fieldkit.recording, "columns", better)


def taken(ledger: Ledger, *paths: Path, **defaults: object) -> Receipt:
    return bring_in(ledger, paths, any_motor, defaults=defaults)


def test_a_log_that_is_measured_better_today_is_there_already(ledger: Ledger, request: pytest.FixtureRequest) -> None:
    (id,) = taken(ledger, PNUT).ids
    ledger.edit(id, rocket="Astra")
    before = ledger.flights()
    request.getfixturevalue("better_measuring")
    again = taken(ledger, PNUT)
    assert (again.ids, again.duplicates, again.rejected) == ((), 1, ())
    assert ledger.flights() == before
    other = taken(ledger, PNUT, rocket="Comet")
    assert [flight.apogee - before[0].apogee for flight in ledger.flights("Comet")] == [pytest.approx(1.0)]
    assert other.duplicates == 0


def test_what_the_flyer_says_of_a_log_is_never_passed_over_in_silence(ledger: Ledger) -> None:
    taken(ledger, PNUT, motor="F24-4W")
    (line,) = taken(ledger, PNUT, motor="G80-7T").rejected
    assert "another motor" in line.error


def test_a_row_whose_log_is_measured_better_today_is_there_already(
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
    low, high = RAVEN.values()
    (id,) = taken(ledger, low, high).ids
    assert ledger.log(id) == low.read_bytes()
    assert ledger.other_logs(id) == [high.read_bytes()]
    assert taken(ledger, low, high).duplicates == taken(ledger, low).duplicates == 1


def test_a_file_alone_says_that_others_may_belong_to_it_and_how_they_come_in(ledger: Ledger) -> None:
    low, high = RAVEN.values()
    first = taken(ledger, low)
    assert any("imported with it" in note for note in first.notes)
    (line,) = taken(ledger, low, high).rejected
    assert "without the other files" in line.error
    ledger.remove(*first.ids)
    assert len(taken(ledger, low, high).ids) == 1
    assert isinstance(ledger.flights()[0], Flight)
