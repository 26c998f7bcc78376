"""Rules for every parser in the folder; a new file is tested before its author writes a test."""

import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.analysis import Recorded, measure
from fieldkit.errors import DamagedLog, FieldkitError
from fieldkit.flight import READOUTS, Column, Flight
from fieldkit.flight.readout import render_sd
from fieldkit.importing import ImportedFile, Parser, Reading
from fieldkit.importing.read import read
from fieldkit.importing.recognize import claims, parser_for, parsers
from tests.effort import examples
from tests.samples import SAMPLES, any_motor, owner, samples_of

GOLDEN = Path(__file__).parent / "golden"
every_sample = pytest.mark.parametrize("sample", SAMPLES, ids=lambda path: path.name)


def rounded(flight: Flight, column: Column, value: float) -> float:
    """A readout as a display shows it, or as well as it was measured."""
    number, sd = float(column.render(value)), flight.sd.get(column.name)
    if sd is None:
        return float(f"{number:.5g}")
    return round(number, -math.floor(math.log10(float(render_sd(column.name, sd)))))


def summary(imported: ImportedFile) -> dict[str, object]:
    """The figures that a flyer would check, in units of the display and rounded like there."""
    flights = [
        {
            "flight_id": flight.flight_id,
            "date_time": flight.date_time and flight.date_time.isoformat(),
            "rocket": flight.rocket,
            "motor": flight.motor,
            "tags": list(flight.tags),
            "dry_mass_kg": flight.dry_mass and round(flight.dry_mass, 4),
        }
        | {c.header: rounded(flight, c, v) for c in READOUTS if (v := flight.number(c.name)) is not None}
        for flight in imported.flights
    ]
    rejected = [f"row {r.row}, {r.column}: {r.error}" for r in imported.rejected]
    return {"flights": flights, "rejected": rejected, "notes": list(imported.notes)}


@contextmanager
def unmeasured() -> Iterator[None]:
    """Skip measuring samples, which has its own tests and takes time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fieldkit.importing.from_samples.measure", lambda clocks, stated: Recorded())
        yield


def troubles(log: bytes, source: str, format: str | None) -> list[str]:
    """The error shown to a flyer for a log; anything but a FieldkitError is a bug and is raised."""
    try:
        with unmeasured():
            imported = read(log, source, any_motor, format)
    except FieldkitError as error:
        return [str(error)]
    return [*(f"{r.file}, row {r.row}: {r.error}" for r in imported.rejected), *imported.notes]


@pytest.mark.parametrize("name", parsers())
def test_every_parser_has_a_sample_log(name: str) -> None:
    assert samples_of(name)


@every_sample
def test_a_sample_is_claimed_only_by_its_own_parser(sample: Path) -> None:
    log = sample.read_bytes()
    assert claims(log) == [owner(sample)]
    assert isinstance(parser_for(log), Parser)


@cache
def first_read(sample: Path) -> ImportedFile:
    """The result of reading a sample."""
    return read(sample.read_bytes(), sample.name, any_motor)


@every_sample
def test_a_sample_has_its_golden_figures(sample: Path) -> None:
    got = summary(first_read(sample))
    assert got == json.loads((GOLDEN / f"{sample.name}.json").read_text(encoding="utf-8"))


def check_samples(reading: Reading) -> None:
    """Report a clock that runs backwards, and channels without numbers or of another length than their clock."""
    for series in reading.clocks:
        assert len(series.time)
        assert np.isfinite(series.time).all()
        assert (np.diff(series.time) >= 0).all()
        for name in (f.name for f in fields(series)):
            values = getattr(series, name)
            if values is not None:
                assert (values.shape, values.dtype) == (series.time.shape, np.float64), name
                assert np.isfinite(values).any(), name
                assert not np.isinf(values).any(), name
    assert all(np.isfinite(when) for when in reading.events.values())


@every_sample
def test_a_clock_never_runs_backwards_and_every_channel_has_numbers(sample: Path) -> None:
    for item in parsers()[owner(sample)].read(sample.read_bytes()):
        if isinstance(item, Reading):
            check_samples(item)


@pytest.mark.sampled
@every_sample
def test_reading_a_log_twice_gives_the_same_flights(sample: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = first_read(sample)
    monkeypatch.setattr("fieldkit.importing.from_samples.measure", measure)  # without results of an earlier measurement
    assert read(sample.read_bytes(), sample.name, any_motor) == before


@cache
def whole_flights(sample: Path) -> int:
    """The number of flights in a whole sample."""
    with unmeasured():
        return len(read(sample.read_bytes(), sample.name, any_motor).flights)


@pytest.mark.sampled
@every_sample
@examples(6)
@given(data=st.data())
def test_a_truncated_log_is_damaged_and_not_a_crash(sample: Path, data: st.DataObject) -> None:
    log = sample.read_bytes()
    torn = log[: data.draw(st.integers(0, len(log) - 1))]
    with unmeasured():
        try:
            imported = read(torn, sample.name, any_motor, format=owner(sample))
        except DamagedLog:
            return
    assert len(imported.flights) <= whole_flights(sample) + 1


@pytest.mark.sampled
@every_sample
@examples(8)
@given(
    cuts=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 40), st.binary(max_size=12)), min_size=1, max_size=6),
    forced=st.booleans(),
)
def test_a_mangled_log_raises_only_errors_that_the_flyer_can_fix(
    sample: Path, cuts: list[tuple[float, int, bytes]], forced: bool
) -> None:
    log = sample.read_bytes()
    for place, length, filling in cuts:
        start = int(place * len(log))
        log = log[:start] + filling + log[start + length :]
    for line in troubles(log, sample.name, owner(sample) if forced else None):
        assert len(line.splitlines()) == 1
        assert line.startswith(sample.name)
    try:
        found = parsers()[owner(sample)].read(log)
    except DamagedLog:
        return
    for item in found:
        if isinstance(item, Reading):
            check_samples(item)


@pytest.mark.parametrize("name", parsers())
@given(log=st.binary(max_size=300) | st.text(max_size=300).map(str.encode))
@examples(25)
def test_random_bytes_are_refused_by_every_parser_in_one_line(name: str, log: bytes) -> None:
    for line in troubles(log, "junk", name):
        assert len(line.splitlines()) == 1
        assert line.startswith("junk")


RESAVED = ("aim_xtra", "altimetercloud", "blueraven_app", "cats", "eggtimer", "featherweight_gps", "mapped_table",
    "micropeak_csv", "openrocket", "perfectflite_table", "rasaero", "raven_fip", "rocksim", "rrc3")  # fmt: skip
"""Parsers of tables that a flyer opens in a spreadsheet, which may save them with semicolons and decimal commas."""


@pytest.mark.parametrize(
    "sample", [s for s in SAMPLES if owner(s) in RESAVED and b";" not in s.read_bytes()[:2000]], ids=lambda s: s.name
)
def test_a_table_saved_with_decimal_commas_reads_the_same(sample: Path) -> None:
    log, parser = sample.read_bytes(), parsers()[owner(sample)]
    if b"," not in log.splitlines()[-2]:
        return  # separated by spaces or tabs: no other separator to try
    saved = re.sub(rb"(?<=\d)\.(?=\d)", b"\0", log).replace(b",", b";").replace(b"\0", b",")
    assert claims(saved) == [owner(sample)]
    ours, theirs = ([c for r in parser.read(one) if isinstance(r, Reading) for c in r.clocks] for one in (log, saved))
    for one, other in zip(ours, theirs, strict=True):
        for channel in one.__slots__:
            np.testing.assert_array_equal(getattr(one, channel), getattr(other, channel), channel)
