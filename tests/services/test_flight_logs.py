"""What a log shows is measured once, and again whenever anything that it depends on has changed."""

import os
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from fieldkit.analysis import Forces
from fieldkit.analysis.force_profile import DragLikelihood, DragProfile
from fieldkit.importing.reading import ColumnChoice
from fieldkit.ledger import Ledger
from fieldkit.paths import HOME, data_file
from fieldkit.selection.logged_forces import FlightLog
from fieldkit.services import flight_logs
from fieldkit.services.imports import bring_in, remeasure
from fieldkit.services.replay import FlightRecordings, Recording
from tests.samples import SAMPLES, any_motor

pytestmark = pytest.mark.fast

CHECK_SHAPES = False

RRC3 = next(sample for sample in SAMPLES if sample.name == "rrc3__feet_and_commas.csv")
TABLE = next(sample for sample in SAMPLES if sample.name == "mapped_table__time_three_axes_total_and_feet.csv")
TWO_FLIGHTS = next(sample for sample in SAMPLES if sample.name == "bdureau__two_flights_and_telemetry_between.txt")


@pytest.fixture
def ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Ledger]:
    monkeypatch.setenv(HOME, str(tmp_path))
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        bring_in(ledger, [RRC3], any_motor)
        yield ledger


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The flights whose logs were read and measured, in order."""
    found: list[str] = []
    read = FlightRecordings.of

    def of(self: FlightRecordings, id: str) -> Recording | None:
        found.append(id)
        return read(self, id)

    monkeypatch.setattr(FlightRecordings, "of", of)
    return found


def shown(ledger: Ledger) -> FlightLog:
    """What the log of the only flight shows."""
    (log,) = flight_logs.flight_logs(ledger, ledger.flights()).values()
    assert isinstance(log, FlightLog)
    return log


def the_same(one: object, other: object) -> bool:
    """Whether two records have the same values, to the last bit."""
    if isinstance(one, np.ndarray):
        return bool(np.array_equal(one, np.asarray(other), equal_nan=one.dtype.kind == "f"))
    if isinstance(one, FlightLog | Forces | DragProfile | DragLikelihood) or hasattr(one, "__slots__"):
        names = type(one).__slots__  # type: ignore[attr-defined]
        return all(the_same(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(the_same, one, other))
    return one == other


def test_a_log_is_measured_once_and_shows_the_same_to_the_last_bit(ledger: Ledger, measured: list[str]) -> None:
    first = shown(ledger)
    assert first.drag is not None
    assert first.forces is not None
    assert the_same(first, shown(ledger))
    assert len(measured) == 1


def test_another_program_measures_again(ledger: Ledger, measured: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    shown(ledger)
    monkeypatch.setattr(flight_logs, "_program", lambda: b"tomorrow's")
    shown(ledger)
    assert len(measured) == 2


def test_another_choice_of_columns_measures_again(
    ledger: Ledger, measured: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bring_in(ledger, [TABLE], any_motor)
    table = ledger.ids(ledger.flights())[-1]
    for choices in ((), (), (ColumnChoice({"altitude": "height"}, ("another table",)),)):
        monkeypatch.setattr(remeasure, "remembered", lambda choices=choices: choices)
        assert flight_logs.flight_log(ledger, table) is not None
    assert measured == [table, table]


def test_the_program_is_every_module_and_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "services").mkdir()
    (tmp_path / "analysis").mkdir()
    monkeypatch.setattr(flight_logs, "__file__", str(tmp_path / "services" / "flight_logs.py"))
    digest, seen = flight_logs._program.__wrapped__, set()
    for name in ("analysis/apogee.py", "analysis/burnout.py", "analysis/apogee.py"):
        (tmp_path / name).write_text(f"# {len(seen)}")
        seen.add(digest())
    assert len(seen) == 3


def test_damaged_measurements_are_not_shown(ledger: Ledger, measured: list[str]) -> None:
    first = shown(ledger)
    (file,) = data_file("measured").iterdir()
    for content in (file.read_bytes()[:-1], b"", bytes(32) + file.read_bytes()[32:]):
        file.write_bytes(content)
        assert the_same(first, shown(ledger))
    assert len(measured) == 4


def test_flights_in_one_file_have_measurements_of_their_own(ledger: Ledger) -> None:
    bring_in(ledger, [TWO_FLIGHTS], any_motor)
    flight_logs.flight_logs(ledger, ledger.flights())
    assert len(list(data_file("measured").iterdir())) == 3


def test_a_flight_whose_place_in_its_file_changes_is_measured_again(ledger: Ledger) -> None:
    bring_in(ledger, [TWO_FLIGHTS], any_motor)
    ids = ledger.ids(ledger.flights())
    before = {id: flight_logs.flight_log(ledger, id) for id in ids}
    one, other = ids[-2:]
    ledger.edit(one, extra=dict(ledger.flight(other).extra))
    assert the_same(flight_logs.flight_log(ledger, one), before[other])


def test_some_of_too_many_are_dropped(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flight_logs, "MAX_LOGS", 1)
    shown(ledger)
    bring_in(ledger, [TWO_FLIGHTS], any_motor)
    letter = data_file("measured") / "letter.txt"
    letter.write_text("of somebody whose folder a link made ours")
    os.utime(letter, (0, 0))
    flight_logs.flight_logs(ledger, ledger.flights())
    assert len(list(data_file("measured").iterdir())) == 2
    assert letter.exists()


def test_most_logs_of_a_ledger_with_a_few_too_many_are_found_when_they_are_read_in_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_logs, "MAX_LOGS", 50)
    monkeypatch.setattr(flight_logs, "_written", lambda log: b"")
    files = [tmp_path / sha256(bytes([number])).hexdigest() for number in range(60)]
    missed = 0
    for number in range(10 * len(files)):
        file = files[number % len(files)]
        if not file.exists():
            missed += number >= len(files)
            flight_logs._keep(file, cast(FlightLog, None))
    assert missed < 9 * len(files) / 2
    assert len(list(tmp_path.iterdir())) == 50


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and links of Unix")
@pytest.mark.parametrize("what", ["a folder", "a pipe", "a link to itself", "a link to an endless device"])
def test_whatever_has_the_name_of_measurements_is_not_waited_for(
    what: str, ledger: Ledger, measured: list[str]
) -> None:
    first = shown(ledger)
    (file,) = data_file("measured").iterdir()
    file.unlink()
    if what == "a pipe":
        os.mkfifo(file)
    elif what == "a folder":
        file.mkdir()
    else:
        file.symlink_to(file if "itself" in what else "/dev/zero")
    assert the_same(first, shown(ledger))
    assert len(measured) == 2


def test_a_folder_that_cannot_be_written_changes_nothing(ledger: Ledger, measured: list[str]) -> None:
    data_file("measured").write_text("a file in its place")
    assert the_same(shown(ledger), shown(ledger))
    assert len(measured) == 2
