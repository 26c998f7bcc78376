"""Spreadsheets (`.xlsx`, `.ods`) are read like CSV with the same cells: flight tables and tables of samples."""

import io
import tracemalloc
import zipfile
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.importing.read import read, read_recordings
from fieldkit.importing.tables import spreadsheet
from fieldkit.importing.tables.spreadsheet_bounds import check_bounds
from tests.samples import any_motor

pandas = pytest.importorskip("pandas")
SAMPLE = Path(__file__).parents[3] / "sample_logs" / "mapped_table__milliseconds_and_no_unit_of_height.csv"
KINDS = {".xlsx": "openpyxl", ".ods": "odf"}


def book(kind: str, **sheets: list[list[object]]) -> bytes:
    """A spreadsheet of these sheets."""
    pytest.importorskip(KINDS[kind])
    out = io.BytesIO()
    with pandas.ExcelWriter(out, engine=KINDS[kind]) as writer:
        for name, rows in sheets.items():
            width = max(map(len, rows))
            rows = [row + [None] * (width - len(row)) for row in rows]
            pandas.DataFrame(rows).to_excel(writer, sheet_name=name, header=False, index=False)
    return out.getvalue()


FLIGHTS: list[list[object]] = [
    ["flight_id", "rocket", "motor", "date_time", "dry_mass_g", "apogee (ft)"],
    ["1", "Astra", "F24-4W", datetime(2025, 5, 3, 10, 15), 310, 820.5],
    ["2", "Astra", "F24-4W", datetime(2025, 5, 3, 11, 0), 312.5, None],
    ["3", "Astra", "F24-4W", datetime(2025, 5, 4), 311, 801],
]


@pytest.mark.parametrize("kind", KINDS)
def test_a_flight_table_is_read_from_any_sheet(kind: str) -> None:
    log = book(kind, notes=[["prepared for the contest"]], flights=FLIGHTS)
    found = read(log, f"table{kind}", any_motor)
    assert found.format == "flight_table"
    assert [flight.flight_id for flight in found.flights] == ["1", "3"]
    assert found.flights[0].apogee == pytest.approx(820.5 * 0.3048)
    assert found.flights[0].date_time == datetime(2025, 5, 3, 10, 15)
    assert [row.row for row in found.rejected] == [3]


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_of_samples_is_read_like_csv(kind: str) -> None:
    rows: list[list[object]] = [
        [cell if row < 2 or not cell.replace(".", "").strip("-").isdigit() else float(cell) for cell in line.split(",")]
        for row, line in enumerate(SAMPLE.read_text().splitlines())
    ]
    (sheet,) = read_recordings(book(kind, samples=rows), f"log{kind}")
    (table,) = read_recordings(SAMPLE.read_bytes(), SAMPLE.name)
    for one, other in zip(sheet.clocks, table.clocks, strict=True):
        assert one.altitude == pytest.approx(other.altitude)
        assert one.time == pytest.approx(other.time)


def test_a_clock_of_dates_keeps_its_milliseconds() -> None:
    start = datetime(2025, 5, 3, 10, 15)
    rows: list[list[object]] = [["Timestamp", "Altitude (ft)"]]
    rows += [[start + timedelta(milliseconds=100 * n), float(max(0, n - 20))] for n in range(100)]
    (log,) = read_recordings(book(".xlsx", log=rows), "log.xlsx")
    assert np.diff(log.clocks[0].time) == pytest.approx(np.full(99, 0.1), abs=2e-3)


def test_a_second_sheet_with_a_table_is_named() -> None:
    second = [[*row[:-1], float(n)] for n, row in enumerate(FLIGHTS[1:], start=200)]
    found = read(book(".xlsx", spring=FLIGHTS, notes=[["none"]], fall=[FLIGHTS[0], *second]), "table.xlsx", any_motor)
    assert [flight.flight_id for flight in found.flights] == ["1", "3"]
    assert any("only one sheet is read; 'fall' also holds a table" in note for note in found.notes)


def test_another_zip_archive_is_not_a_spreadsheet() -> None:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("flight.csv", "time,altitude\n")
    with pytest.raises(UnknownFormat, match="unpack it"):
        read(out.getvalue(), "logs.zip", any_motor)


def test_a_spreadsheet_beyond_the_bounds_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spreadsheet, "MAX_UNPACKED", 1000)
    with pytest.raises(DamagedLog, match="MB in a spreadsheet"):
        read(book(".xlsx", flights=FLIGHTS), "table.xlsx", any_motor)


def test_a_truncated_spreadsheet_is_damaged_and_not_a_crash() -> None:
    log = book(".xlsx", flights=FLIGHTS)
    for part in (0.3, 0.6, 0.9):
        with pytest.raises((DamagedLog, UnknownFormat)):
            read(log[: int(part * len(log))], "table.xlsx", any_motor)
    with zipfile.ZipFile(io.BytesIO(log)) as archive:
        names = {name: archive.read(name) for name in archive.namelist()}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, content in names.items():
            archive.writestr(name, content[: len(content) // 2] if name.startswith("xl/") else content)
    with pytest.raises(DamagedLog, match="cannot be read"):
        read(out.getvalue(), "table.xlsx", any_motor)


XLSX = {
    "xl/workbook.xml": '<workbook><sheets><sheet name="S" sheetId="1"/></sheets></workbook>',
    "xl/sharedStrings.xml": f"<sst><si><t>{'x' * 60_000}</t></si></sst>",
}
TEXT_CELL = '<c t="s"><v>0</v></c>'
ODS = "<d><table>{}</table></d>"
HOSTILE = {
    "opposite corners": {"xl/s.xml": '<w><row r="1"><c r="A1"/></row><row r="1048576"><c r="XFD1048576"/></row></w>'},
    "a prefix": {"xl/s.xml": '<x:w xmlns:x="n"><x:row><x:c r="XFD1048576"/></x:row></x:w>'},
    "a shared text": {"xl/s.xml": "<w><row>" + '<c t="s"><v>0</v></c>' * 10_000 + "</row></w>"},
    "an entity": {"xl/s.xml": '<!DOCTYPE w [<!ENTITY a "b">]><w><row><c><v>&a;</v></c></row></w>'},
    "cells of many sheets": {f"xl/s{n}.xml": '<w><row r="2000"><c r="ALL2000"/></row></w>' for n in range(5)},
    "a text of many sheets": {
        f"xl/s{n}.xml": "<w><row>" + '<c t="s"><v>0</v></c>' * 500 + "</row></w>" for n in range(9)
    },
    "a torn sheet": {"xl/s.xml": '<w><row><c r="A1"><v>1</v></c>'},
    "a row of letters": {"xl/s.xml": '<w><row r="one"><c/></row></w>'},
    "spaces": {"content.xml": ODS.format('<table-row><table-cell><p><s c="2000000000"/></p></table-cell></table-row>')},
    "a repeated text": {
        "content.xml": ODS.format(
            '<table-row number-rows-repeated="1000000"><table-cell><p>' + "x" * 500 + "</p></table-cell></table-row>"
        )
    },
    "a repeated cell": {
        "content.xml": ODS.format(
            '<table-row number-rows-repeated="1000000"><table-cell value-type="float" number-columns-repeated="16384"/>'
            "</table-row>"
        )
    },
}


@pytest.mark.parametrize("parts", HOSTILE.values(), ids=HOSTILE)
def test_a_spreadsheet_that_expands_beyond_memory_is_refused_before_it_is_read(parts: dict[str, str]) -> None:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (XLSX | parts).items():
            archive.writestr(name, content)
    with zipfile.ZipFile(out) as archive, pytest.raises(DamagedLog, match="found"):
        check_bounds(archive)


def test_a_table_that_starts_in_another_column_keeps_the_empty_ones() -> None:
    rows = [[None, None, None], [None, "a", "b"], [None, 1.5, 2]]
    (found,) = spreadsheet._sheets(book(".xlsx", log=rows))
    assert found == ("log", b",,\n,a,b\n,1.5,2\n")


@pytest.mark.sampled
@pytest.mark.parametrize("kind", KINDS)
def test_a_large_spreadsheet_is_read_row_by_row(kind: str) -> None:
    """Only its text is in memory: a cell as an object would take 30 bytes, and its place in a list 8."""
    log = book(kind, log=[[n + 0.125] * 8 for n in range(4000)])
    tracemalloc.start()
    try:
        (found,) = spreadsheet._sheets(log)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2.5 * len(found[1]) + 500_000


def test_empty_rows_below_a_table_are_not_counted() -> None:
    empty = '<table-row number-rows-repeated="1048576"><table-cell number-columns-repeated="16384"/></table-row>'
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("content.xml", ODS.format("<table-row><table-cell><p>1</p></table-cell></table-row>" + empty))
    with zipfile.ZipFile(out) as archive:
        check_bounds(archive)
