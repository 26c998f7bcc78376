"""Which parser reads a file: the most certain first, the next if it finds no flight, and what an unknown file lacks."""

import random
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog, FieldkitError, UnknownFormat
from fieldkit.flight import Series
from fieldkit.importing import Parsed, Parser, Reading, recognize
from fieldkit.importing.likeness import likeness, nearest
from fieldkit.importing.read import read
from fieldkit.importing.recognize import claims, holds_flight, open_log, parser_for, parsers
from fieldkit.physics.standard_atmosphere import pressure_height
from tests.analysis.recordings import SMALL, Logger, fly, log
from tests.effort import part
from tests.samples import SAMPLES, any_motor, owner

CHECK_SHAPES = False
every_sample = pytest.mark.parametrize("sample", SAMPLES, ids=lambda path: path.name)
ROW, THOUSANDS = re.compile(rb"\s*-?[\d.]+\s*[,;\t]"), re.compile(rb"^\s*(-?\d{1,3})(\d{3}(?:\.\d*)?)\s*$")
TABLE = b"rocket,apogee_m\nSwift,100\n"


def table_of_samples(header: str) -> bytes:
    """A small flight as a table of seconds and meters."""
    (series,) = log(fly(SMALL), Logger(), np.random.default_rng(0))
    assert series.altitude is not None
    rows = zip(series.time, series.altitude, strict=True)
    return (header + "\n" + "".join(f"{time:.3f},{height:.2f}\n" for time, height in rows)).encode()


def with_parser(monkeypatch: pytest.MonkeyPatch, parser: Parser) -> None:
    known = {**parsers(), "other": parser}
    monkeypatch.setattr(recognize, "parsers", lambda: known)


def heights(found: object) -> float:
    """The greatest height above its own start that any barometer or satellite receiver shows. [m]"""
    best = 0.0
    for item in found if isinstance(found, list | tuple) else []:
        for series in item.clocks if isinstance(item, Reading) else ():
            for name in ("altitude", "altitude_msl", "gps_altitude_msl", "pressure", "inertial_altitude"):
                values = getattr(series, name)
                if values is not None and np.isfinite(values).sum() > 8:
                    values = values[np.isfinite(values)]
                    values = pressure_height(values) if name == "pressure" else values
                    best = max(best, float(np.quantile(values, 0.995) - np.median(values[:5])))
    return best


def test_signs_are_quoted_as_the_file_spells_them() -> None:
    like = likeness(parsers()["flight_table"], b"rocket,motor,apogee_ft\nSwift,C6-5,500\n")
    assert like.found == ("rocket", "motor", "apogee_ft")
    assert like.missing == ("date_time",)


@pytest.mark.sampled
@every_sample
def test_no_parser_claims_the_sample_of_another_or_reads_a_flight_of_another_height_in_it(sample: Path) -> None:
    content = sample.read_bytes()
    assert claims(content) == [owner(sample)]
    own = heights(parsers()[owner(sample)].read(content))
    for name, parser in parsers().items():
        if name == owner(sample):
            continue
        try:
            found: list[Parsed] = list(parser.read(content))
        except DamagedLog:
            continue
        got = heights(found)
        assert not (own and got) or name == "mapped_table" or got == pytest.approx(own, rel=0.05), name


@pytest.mark.sampled
@every_sample
def test_a_sample_matches_its_own_parser_best(sample: Path) -> None:
    parser = parsers()[owner(sample)]
    if not parser.signs or b"tabs_without_a_header" in sample.name.encode():
        return
    own = likeness(parser, sample.read_bytes())
    assert own.part >= 0.5, own.missing
    assert owner(sample) in [name for name, _ in nearest(parsers(), sample.read_bytes())]


def resaved(text: bytes) -> Iterator[tuple[str, bytes]]:
    """The table in a log as spreadsheets save it, and the change; nothing for other logs."""
    lines = text.split(b"\n")
    rows = (i for i in range(1, min(len(lines) - 6, 60)) if all(map(ROW.match, lines[i : i + 5])))
    if (start := next(rows, None)) is None:
        return
    mark = max((b"\t", b";", b","), key=lines[start].count)
    above, table = lines[: start - 1], [line.split(mark) for line in lines[start - 1 :] if line.strip()]
    order = random.Random(len(text)).sample(range(len(table[0])), len(table[0]))
    shuffled = [[row[i] for i in order] if len(row) == len(order) else row for row in table]
    spaced = [[b" " + cell + b" " for cell in table[0]], *table[1:]]
    units = [re.search(rb"[(\[]([^()\[\]]*)[)\]]", cell) for cell in table[0]]
    names = [re.sub(rb"\s*[(\[][^()\[\]]*[)\]]", b"", cell) for cell in table[0]]
    saved = {
        "in quotation marks": [[b'"' + cell.strip() + b'"' for cell in row] for row in table],
        "with commas between thousands": [[THOUSANDS.sub(rb'"\1,\2"', cell) for cell in row] for row in table],
        "with empty cells at the end": [[*row, b"", b""] for row in table],
        "with its columns in another order": shuffled,
        "with spaces around its names": spaced,
        "with units in brackets": [[re.sub(rb"\(([^()]*)\)", rb"[\1]", cell) for cell in table[0]], *table[1:]],
        "with units behind underscores": [[b"_".join(c.strip(b"()").split(b" (")) for c in table[0]], *table[1:]],
        "with a line of units": [names, [unit[1] if unit else b"" for unit in units], *table[1:]],
    }
    for how, cells in saved.items():
        if mark == b"," or how != "with commas between thousands":
            yield how, b"\n".join([*above, *map(mark.join, cells), b""])


def mutated(content: bytes) -> Iterator[tuple[str, bytes]]:
    """The text of a log with its first lines spelled differently, and the change."""
    head, _, rest = content.partition(b"\n")
    yield "in capitals", head.upper() + b"\n" + rest
    yield "with a byte order mark", b"\xef\xbb\xbf" + content
    yield "behind a blank line", b"\r\n" + content
    yield "behind a title", b"Saturday at the field\n" + content
    text = content.replace(b"\r\n", b"\n")
    yield "with Windows line ends", text.replace(b"\n", b"\r\n")
    yield "with every other line blank", text.replace(b"\n", b"\n\n")
    yield "in UTF-16", text.decode("utf-8-sig", "replace").encode("utf-16")
    yield from resaved(text)
    for separator in (b",", b";", b"\t"):
        cells = head.split(separator)
        for place in range(min(len(cells), 8)) if len(cells) > 1 else ():
            other = [*cells[:place], b"zzz", *cells[place + 1 :]]
            yield f"without {cells[place].decode('latin-1')!r}", separator.join(other) + b"\n" + rest


@pytest.mark.sampled
@every_sample
def test_a_mutated_header_is_read_the_same_or_refused_and_never_read_wrong(sample: Path) -> None:
    content = sample.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")) or owner(sample) in ("flight_table", "altimetertwo_journal"):
        return
    own = heights(open_log(content, "log", None).found)
    for how, changed in part([*mutated(content)], SAMPLES.index(sample)):
        with suppress(FieldkitError):
            opened = open_log(changed, "log", None)
            if got := heights(opened.found):
                assert got == pytest.approx(own, rel=0.08), f"{how}: as {opened.format}"


def test_for_an_unknown_file_the_nearest_formats_are_reported_with_what_it_lacks() -> None:
    content = b"Time,Altitude,Pressure,Velocity,Temp\n" + b"0,x,y,z,w\n" * 5
    with pytest.raises(UnknownFormat) as error:
        read(content, "odd.csv", any_motor)
    message = str(error.value)
    assert "RRC3 (mDACS) (rrc3) lacks 'Temperature', 'Events', 'Voltages'" in message
    assert message.count(" lacks ") <= 3
    assert "blueraven_usb" not in message


def test_the_parser_with_more_matching_signs_is_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    greedy = Parser("Greedy", lambda head: True, lambda content: [Reading({"apogee": 100.0})])
    with_parser(monkeypatch, greedy)
    assert parser_for(TABLE).title == "Flight table"
    assert parser_for(TABLE, format="other") is greedy


def test_equally_certain_parsers_are_both_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with_parser(monkeypatch, Parser("Twin", *_of("flight_table"), signs=parsers()["flight_table"].signs))
    with pytest.raises(UnknownFormat, match="flight_table and other both recognize"):
        parser_for(TABLE)


def _of(name: str) -> tuple[object, object]:
    return parsers()[name].recognises, parsers()[name].read


@pytest.mark.parametrize("finds", ["nothing", "an empty flight", "damage"])
def test_a_claimed_log_without_a_flight_falls_back_to_a_table_of_samples(
    monkeypatch: pytest.MonkeyPatch, finds: str
) -> None:
    def empty(content: bytes) -> list[Parsed]:
        if finds == "damage":
            raise DamagedLog("found no frame, expected one")
        flat = Series(np.arange(20.0), altitude=np.full(20, 3.0))
        return [Reading(series=flat)] if finds == "an empty flight" else []

    with_parser(monkeypatch, Parser("Claims all", lambda head: True, empty, signs=("time (s)",)))
    opened = open_log(table_of_samples("time (s),altitude (m)"), "log.csv", None)
    assert opened.format == "mapped_table"
    assert holds_flight(opened.found)
    imported = read(table_of_samples("time (s),altitude (m)"), "log.csv", any_motor)
    assert imported.flights[0].apogee == pytest.approx(fly(SMALL).readouts()["apogee"], abs=1.0)
    assert any("Claims all recognizes it and" in note for note in imported.notes)


def test_a_claim_is_kept_if_no_other_parser_finds_a_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged(content: bytes) -> list[Parsed]:
        raise DamagedLog("found no frame, expected one", row=3)

    with_parser(monkeypatch, Parser("Claims all", lambda head: True, damaged, signs=("a",)))
    with pytest.raises(DamagedLog, match=r"^x\.csv, row 3: found no frame"):
        open_log(b"a,b\n1,2\n", "x.csv", None)


def test_a_damaged_simulation_is_not_mistaken_for_a_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged(content: bytes) -> list[Parsed]:
        raise DamagedLog("found units that disagree")

    parser = Parser("Simulator", lambda head: True, damaged, signs=("time (s)",), simulates=True)
    with_parser(monkeypatch, parser)
    with pytest.raises(DamagedLog, match="units that disagree"):
        open_log(table_of_samples("time (s),altitude (m)"), "log.csv", None)
