"""Counts in files of unknown origin are bounded, and reading never waits for a pipe or a device."""

import contextlib
import gzip
import io
import os
import resource
import subprocess
import sys
import threading
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from fieldkit import zips
from fieldkit.cli.main import main
from fieldkit.errors import DamagedLog, FieldkitError
from fieldkit.importing import MOST_FLIGHTS, Reading, from_samples
from fieldkit.importing.read import read
from fieldkit.importing.recognize import parsers
from fieldkit.motors import draft, own
from fieldkit.openrocket import archive, read_design, stored
from fieldkit.openrocket import design as designs
from fieldkit.settings import Settings, read_settings
from tests.openrocket.test_design import design
from tests.samples import any_motor

CHECK_SHAPES = False
ROOT = Path(__file__).parents[2]
POINT = "1," * 60 + "1"


def zipped(text: str, names: int = 1) -> bytes:
    """A design as OpenRocket writes it, among other files."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("rocket.ork", text)
        for number in range(names - 1):
            packed.writestr(f"decals/{number}", "")
    return out.getvalue()


def simulated(titles: str, points: str) -> str:
    """A design with a stored simulation."""
    branch = f'<flightdata><databranch types="{titles}">{points}</databranch></flightdata>'
    simulation = f'<simulations><simulation status="uptodate"><name>s</name>{branch}</simulation></simulations>'
    return design().replace("</openrocket>", f"{simulation}</openrocket>")


def nested(depth: int) -> str:
    """A design with nested parts."""
    inside = "<subcomponents><innertube>" * depth + "</innertube></subcomponents>" * depth
    return design().replace("</subcomponents>", f"{inside}</subcomponents>", 1)


HOSTILE: dict[str, Callable[[], bytes]] = {
    "titles and points": lambda: zipped(simulated("Time," * 200_000, "<datapoint>1,2,3</datapoint>" * 100_000)),
    "points": lambda: zipped(simulated("Time", "<datapoint>1</datapoint>" * 600_000)),
    "cells": lambda: zipped(simulated("Time", f"<datapoint>{'1,' * 400_000}</datapoint>" * 5)),
    "elements": lambda: gzip.compress(b"<openrocket><rocket>" + b"<a/>" * 5_000_000),
    "attributes": lambda: zipped("<openrocket " + " ".join(f'a{n}="1"' for n in range(400_000)) + "/>"),
    "nesting": lambda: zipped(nested(20_000)),
    "parts": lambda: zipped(design().replace("<nosecone>", "<bodytube/>" * 100_000 + "<nosecone>", 1)),
    "files": lambda: zipped(design(), names=2000),
    "encoding": lambda: b'<?xml version="1.0" encoding="cp037"?>' + ("<a>" * 100).encode("cp037"),
    "a name without end": lambda: zipped(design().replace("Skylark", "x" * 3_000_000)),
}
"""Designs with too much of something, by its name."""


READ_ALL = """
import sys, time
from fieldkit.cli.main import main
for file in sys.argv[1:]:
    began = time.monotonic()
    print(main(["ork", "--look", file]), time.monotonic() - began, flush=True, file=sys.stderr)
memory = [line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")]
print(int(memory[0]) // 1024, file=sys.stderr)
"""
"""Reads designs one after the other; status and time of each, and the memory that the process took. [s, MiB]"""


@pytest.mark.thorough
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux reports the memory")
def test_designs_with_too_much_of_something_are_read_or_refused_at_once(tmp_path: Path) -> None:
    files = [tmp_path / f"{what.replace(' ', '_')}.ork" for what in HOSTILE]
    for file, content in zip(files, HOSTILE.values(), strict=True):
        file.write_bytes(content())
    done = subprocess.run(
        [sys.executable, "-c", READ_ALL, *map(str, files)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    *message, megabytes = done.stderr.splitlines()
    assert int(megabytes) < 600
    assert "Traceback" not in done.stderr
    statuses = dict(zip(files, (line.split() for line in message if line[0] in "01"), strict=True))
    assert statuses[files[0]][0] == "0", "titles beyond those known are passed over"
    for file, (status, seconds) in statuses.items():
        assert float(seconds) < 60
        assert status == "0" or any(line.startswith(f"{file.name}") for line in message)


def test_the_error_names_what_a_design_has_too_much_of(monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name, most, text, message in (
        (archive, "MOST_ELEMENTS", 20, zipped(design()), "more than 20 elements"),
        (archive, "MAX_DEPTH", 5, zipped(design()), "nested more than 5 deep"),
        (archive, "MAX_TAG_LENGTH", 20, zipped(design()), "without the end of a tag"),
        (zips, "MAX_ENTRIES", 2, zipped(design(), names=3), "more than 2 files"),
        (designs, "MOST_PARTS", 1, zipped(design()), "parts along the body"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, most)
            with pytest.raises(DamagedLog, match=message):
                read_design(text, "x.ork")


@pytest.mark.sampled
@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA, zipfile.ZIP_DEFLATED])
@pytest.mark.parametrize("part", ["rocket.ork", "mimetype", "xl/workbook.xml"])
def test_small_archives_never_expand_to_much_memory(part: str, method: int) -> None:
    """Forty megabytes of zeros in a few hundred bytes of bzip2; `mimetype` is read to recognize a spreadsheet."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as packed, packed.open(part, "w") as file:
        for _ in range(40):
            file.write(bytes(1 << 20))
    with zipfile.ZipFile(out, "a") as packed:
        packed.writestr("content.xml", "<a/>")
    content = out.getvalue()
    tracemalloc.start()
    try:
        with pytest.raises(FieldkitError):
            read_design(content, "x.ork") if part.endswith(".ork") else read(content, "x.xlsx", lambda name: None)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < (100 << 20 if part.endswith(".ork") and method == zipfile.ZIP_DEFLATED else 30 << 20)


def test_excess_columns_of_a_simulation_are_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    points = "".join(f"<datapoint>{t},0.35,0.05</datapoint>" for t in range(10))
    titles = "Time,Mass,Motor mass"
    assert read_design(zipped(simulated(titles, points)), "x.ork").dry_mass == pytest.approx(0.30)
    monkeypatch.setattr(stored, "MOST_COLUMNS", 2)
    assert read_design(zipped(simulated(titles, points)), "x.ork").dry_mass != pytest.approx(0.30)


def test_motors_in_a_file_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(draft, "MAX_MOTORS", 2)
    motor = b"X1 18 70 4 0.01 0.02 Me\n0.1 5\n1 0\n"
    assert len(own.read(2 * motor, "x.eng")) == 2
    with pytest.raises(DamagedLog, match="more than 2 motors"):
        own.read(3 * motor, "x.eng")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
@pytest.mark.parametrize("of", ["pipe", "device"])
@pytest.mark.parametrize(
    "words",
    [["import"], ["ork"], ["motors", "--import"], ["predict", "--flights"], ["compare", "1"]],
    ids=lambda words: words[0],
)
def test_no_command_waits_for_a_pipe_or_a_device(
    words: list[str], of: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    (tmp_path / "t.csv").write_text("flight_id,rocket,motor,apogee_m\n1,Astra,F24-4W,100\n")
    assert main(["import", str(tmp_path / "t.csv")]) == 0
    file = tmp_path / "hanging.ork"
    os.mkfifo(file) if of == "pipe" else file.symlink_to("/dev/zero")
    status: list[int] = []
    command = threading.Thread(target=lambda: status.append(main([*words, str(file)])), daemon=True)
    command.start()
    command.join(20)
    assert status == [1]
    *_, message = capsys.readouterr().err.splitlines()
    assert "hanging.ork" in message
    assert "a pipe or a device" in message or words == ["compare", "1"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
@pytest.mark.parametrize("name", ["settings.json", "mappings.json", "limits.toml", "drills.toml", "motors/x.eng"])
def test_a_pipe_in_place_of_one_of_fieldkits_files_is_not_waited_for(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "motors").mkdir()
    os.mkfifo(tmp_path / name)
    words = ["--ledger", str(tmp_path / "ledger.db"), "predict", "--motor", "F24-4W", "--dry-mass", "300g"]
    command = threading.Thread(target=lambda: main(words), daemon=True)
    command.start()
    command.join(30)
    assert not command.is_alive()


@pytest.mark.parametrize("text", ["[" * 100_000, '{"units": ' * 50_000, "\ud800".encode("utf-8", "surrogatepass")])
def test_unreadable_settings_are_replaced_by_the_defaults(text: str | bytes, tmp_path: Path) -> None:
    file = tmp_path / "settings.json"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    assert read_settings(file) == Settings()


DEEP = {
    "json": b'{"flights": ' + b"[" * 200_000,
    "json of objects": b'{"flights": [' + b'{"a":' * 100_000,
    "columns": (",".join(f"c{n}" for n in range(200_000)) + "\n" + ("1," * 199_999 + "1\n") * 3).encode(),
    "time and columns": (
        "time,altitude," + ",".join(f"c{n}" for n in range(100_000)) + "\n" + (POINT + "\n") * 500
    ).encode(),
}


@pytest.mark.parametrize("what", DEEP)
def test_an_extremely_nested_or_wide_log_is_read_or_refused(what: str) -> None:
    began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with contextlib.suppress(FieldkitError):
        read(DEEP[what], "wide.csv", lambda name: None)
    assert time.monotonic() - began < 20
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 600 * 1024


FEW = b"time (s),altitude (m)\n" + b"".join(b"%.1f,%d\n" % (n / 10, n) for n in range(100))
LABELED = b"".join(b"t=%d.0 alt=%d.0\n" % (n, n) for n in range(80))
DENSE = {
    "json of empty objects": b'{"a":[' + b"{}," * 1_700_000 + b"{}]}",
    "json of short rows": b'{"columns":["time_s","altitude_m"],"data":[' + b"[1,2]," * 800_000 + b"[1,2]]}",
    "lines in quotation marks": b'"1,2"\n' * 800_000,
    "one line in quotation marks": b'"1,2"\n' * 80 + b'"' + b'""' * 2_500_000 + b"x",
    "cited lines": b"> 1,2\n" * 800_000,
    "labeled lines": LABELED + b"t=1 alt=2\n" * 300_000,
    "commas": FEW + b"," * 4_200_000,
    "lines of one quotation mark": FEW + b'"\n' * 1_000_000,
}
"""Texts of a few bytes for each thing that a reader makes of them."""


@pytest.mark.sampled
@pytest.mark.parametrize("what", DENSE)
def test_many_short_things_take_little_memory_and_time(what: str) -> None:
    began = time.process_time()
    tracemalloc.start()
    try:
        with contextlib.suppress(FieldkitError):
            read(DENSE[what], "dense.csv", lambda name: None)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 12 * len(DENSE[what]) + (30 << 20)
    assert time.process_time() - began < 30


@pytest.mark.parametrize("place", ['"n\\ud800": [{0}]', '"n": [{0}, "\\udcff"]'])
def test_half_a_pair_of_surrogates_in_json_is_shown_as_such(place: str) -> None:
    numbers = ",".join(map(str, range(20)))
    text = f'{{"time_s": [{numbers},20], "altitude_m": [{numbers},20], {place.format(numbers)}}}'
    assert read(text.encode(), "x.json", lambda name: None).format == "mapped_table"


@pytest.mark.parametrize("step", ["e-300", "e-30", "e-9", "e11"])
def test_a_clock_of_any_step_is_of_a_flight_or_refused(step: str) -> None:
    rows = "".join(f"{n}{step},{min(n, 100 - n)}\n" for n in range(100))
    found = read(f"time (s),altitude (m)\n{rows}".encode(), "x.csv", lambda name: None)
    assert not found.flights
    assert found.rejected


def test_the_columns_of_a_table_of_flights_are_counted() -> None:
    names = "".join(f",x{n}" for n in range(500))
    with pytest.raises(DamagedLog, match="found 503 columns in a table of flights, expected at most 500"):
        read(f"flight_id,motor,apogee_m{names}\n1,F24-4W,100\n".encode(), "x.csv", lambda name: None)


def test_a_text_too_large_to_convert_is_refused_with_the_limit() -> None:
    text = LABELED + b"t=1 alt=2\n" * (3 << 20) + b"t=1 alt=2\n" * (1 << 18)
    with pytest.raises(FieldkitError, match="more than 32 MB are not read"):
        read(text, "x.txt", lambda name: None)


def test_the_flights_of_a_log_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is measured, which takes a fifth of a second: the first ones are read, and the log is named as too long."""
    sample = (ROOT / "sample_logs" / "altos_eeprom__easymini.eeprom").read_bytes()
    log = sample + sample.partition(b"}")[2] * 5
    assert len(read(log, "many.eeprom", any_motor).flights) == 6
    monkeypatch.setattr(from_samples, "MOST_FLIGHTS", 3)
    imported = read(log, "many.eeprom", any_motor)
    assert len(imported.flights) == 3
    assert [one.error for one in imported.rejected] == [
        "found more than 3 flights in a log, read the first ones; split it"
    ]


@pytest.mark.parametrize(
    ("name", "text"), [("perfectflite", "perfectflite__drogue_and_main.pf2"), ("eggtimer", "eggtimer__classic.csv")]
)
def test_no_parser_leaves_out_further_flights_in_silence(name: str, text: str) -> None:
    """Of more flights than are read, a parser returns enough to be noticed."""
    log = (ROOT / "sample_logs" / text).read_bytes()
    found = parsers()[name].read(log * (MOST_FLIGHTS + 9))
    assert sum(isinstance(one, Reading) for one in found) > MOST_FLIGHTS


@pytest.mark.parametrize("size", [30, 400, 0.5, -30])
def test_a_workbook_that_is_cut_off_is_called_damaged(size: float) -> None:
    workbook = zipped("<workbook/>", names=9)
    end = int(size * len(workbook)) if isinstance(size, float) else size
    with pytest.raises(FieldkitError, match=r"is an archive that cannot be opened .*; download or save it again"):
        read(workbook[:end], "book.xlsx", any_motor)
