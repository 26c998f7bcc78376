"""Spreadsheets (`.xlsx`, `.ods`) are read like CSV with the same cells: flight tables and tables of samples."""

import csv
import io
import tracemalloc
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.importing.read import read, read_recordings
from fieldkit.importing.tables import sheet_xml, spreadsheet
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


def test_many_sheets_with_tables_are_counted() -> None:
    found = read(book(".xlsx", **{f"s{number}": FLIGHTS for number in range(9)}), "table.xlsx", any_motor)
    assert any("'s1', 's2', 's3', 's4' and 4 more also hold a table" in note for note in found.notes)


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


WORKBOOK = '<workbook xmlns:r="r"><sheets>{}</sheets></workbook>'
RELATIONS = "<Relationships>{}</Relationships>"
SHARED = f"<sst><si><t>{'x' * 30_000}</t></si></sst>"
ODS = '<d xmlns:o="o"><table o:name="S">{}</table></d>'


def archive(**parts: str) -> bytes:
    """A zip archive of these parts, `__` for a slash."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in parts.items():
            packed.writestr(f"{name.replace('__', '/')}.xml" if "." not in name else name.replace("__", "/"), content)
    return out.getvalue()


def xlsx(*parts: str, targets: Sequence[str] = (), **more: str) -> bytes:
    """A workbook with these XML parts as sheets, or with `targets` as the part of each sheet."""
    targets = targets or [f"worksheets/sheet{n}.xml" for n in range(len(parts))]
    named = "".join(f'<sheet name="S{n}" r:id="a{n}"/>' for n in range(len(targets)))
    related = "".join(f'<Relationship Id="a{n}" Type="x/worksheet" Target="{t}"/>' for n, t in enumerate(targets))
    return archive(
        xl__workbook=WORKBOOK.format(named),
        **{"xl___rels__workbook.xml.rels": RELATIONS.format(related)},
        **{f"xl__worksheets__sheet{n}": part for n, part in enumerate(parts)},
        xl__sharedStrings=SHARED,
        **more,
    )


SHEET = "<w><row>{}</row></w>"
HOSTILE = {
    "opposite corners": xlsx(
        '<w><row r="1"><c r="A1"><v>1</v></c></row><row r="1048576"><c r="XFD1048576"><v>1</v></c></row></w>'
    ),
    "a prefix": xlsx('<x:w xmlns:x="n"><x:row r="1048576"><x:c r="XFD1048576"><x:v>1</x:v></x:c></x:row></x:w>'),
    "a shared text": xlsx(SHEET.format('<c t="s"><v>0</v></c>' * 10_000)),
    "an entity": xlsx('<!DOCTYPE w [<!ENTITY a "b">]><w><row><c><v>&a;</v></c></row></w>'),
    "an entity of another file": xlsx('<!DOCTYPE w SYSTEM "a.dtd"><w><row><c><v>&a;</v></c></row></w>'),
    "an undefined entity": xlsx("<w>&a;<row><c><v>1</v></c></row></w>"),
    "a doubled attribute": xlsx('<w><row r="1" r="2"><c><v>1</v></c></row></w>'),
    "a wrong end tag": xlsx("<w><a></b><row><c><v>1</v></c></row></w>"),
    "a control character": xlsx("<w>\x01<row><c><v>1</v></c></row></w>"),
    "an undefined entity in styles": xlsx(SHEET.format("<c><v>1</v></c>"), xl__styles="<s>&a;</s>"),
    "cells of many sheets": xlsx(*5 * ['<w><row r="2000"><c r="ALL2000"><v>1</v></c></row></w>']),
    "a text of many sheets": xlsx(*9 * [SHEET.format('<c t="s"><v>0</v></c>' * 500)]),
    "sheets that share a part": xlsx(SHEET.format("<c><v>1</v></c>"), targets=2 * ["worksheets/sheet0.xml"]),
    "a torn sheet": xlsx('<w><row><c r="A1"><v>1</v></c>'),
    "a missing sheet": xlsx(targets=["worksheets/sheet0.xml"]),
    "a row of letters": xlsx('<w><row r="one"><c><v>1</v></c></row></w>'),
    "a cell without letters": xlsx(SHEET.format('<c r="12"><v>1</v></c>')),
    "rows upward": xlsx('<w><row r="2"><c><v>1</v></c></row><row r="1"><c><v>1</v></c></row></w>'),
    "a shared text that is missing": xlsx(SHEET.format('<c t="s"><v>7</v></c>')),
    "a long text": xlsx(SHEET.format(f"<c><v>{'x' * 200_000}</v></c>")),
    "a long tag": xlsx(SHEET.format(f'<c a="{"x" * 3_000_000}"/>')),
    "a long comment": xlsx(f"<w><!--{'x' * 3_000_000}--></w>"),
    "depth": xlsx(f"<w>{'<a>' * 200}{'</a>' * 200}</w>"),
    "nothing": xlsx(SHEET.format('<c r="XFD1048576"/>')),
    "spaces": archive(
        content=ODS.format('<table-row><table-cell><p><s o:c="2000000000"/></p></table-cell></table-row>')
    ),
    "an undefined entity before a table": archive(content=f"<d>&a;{ODS.format('')}</d>"),
    "many sheets": archive(
        content=f"<d>{'<table><table-row><table-cell><p>1</p></table-cell></table-row></table>' * 1001}</d>"
    ),
    "a count of letters": archive(content=ODS.format('<table-row o:number-rows-repeated="x"/>')),
    "a repeated text": archive(
        content=ODS.format(
            f'<table-row o:number-rows-repeated="1000000"><table-cell><p>{"x" * 500}</p></table-cell></table-row>'
        )
    ),
    "a repeated cell": archive(
        content=ODS.format(
            '<table-row o:number-rows-repeated="1000000"><table-cell o:value-type="float" o:value="1"'
            ' o:number-columns-repeated="16384"/></table-row>'
        )
    ),
}


@pytest.mark.parametrize("log", HOSTILE.values(), ids=HOSTILE)
def test_a_spreadsheet_that_is_damaged_or_expands_beyond_memory_is_refused_in_little_memory(log: bytes) -> None:
    assert len(log) < 40_000
    tracemalloc.start()
    try:
        with pytest.raises(DamagedLog, match="found"):
            spreadsheet.as_csv(log, lambda sheet: False)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 200 << 20


def test_the_number_of_elements_is_limited_even_without_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sheet_xml, "MAX_ELEMENTS", 100)
    with pytest.raises(DamagedLog, match="elements"):
        list(spreadsheet.sheets(xlsx(SHEET.format("<c/>" * 100))))


@pytest.mark.sampled
@given(st.sampled_from(sorted(KINDS)), st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
def test_a_spreadsheet_with_any_damage_inside_is_read_or_refused(kind: str, data: st.DataObject) -> None:
    with zipfile.ZipFile(io.BytesIO(small_book(kind))) as packed:
        parts = {name: packed.read(name) for name in packed.namelist()}
    name = data.draw(st.sampled_from(sorted(parts)))
    at = data.draw(st.integers(0, len(parts[name])))
    piece = data.draw(
        st.sampled_from([b"", b"<", b">", b'"', b"&a;", b"&#0;", b"\xff", b"9" * 30, b"</row>", b"]]>", b"<a>"])
    )
    parts[name] = parts[name][:at] + piece + parts[name][at + data.draw(st.integers(0, 20)) :]
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for part, content in parts.items():
            packed.writestr(part, content)
    with suppress(DamagedLog):
        spreadsheet.as_csv(out.getvalue(), lambda sheet: False)


@cache
def small_book(kind: str) -> bytes:
    """A spreadsheet of the flights."""
    return book(kind, flights=FLIGHTS, notes=[["none", 1.5]])


CELLS = st.one_of(
    st.none(),
    st.text(
        st.characters(codec="utf-8", exclude_categories=("Cc", "Cs"), exclude_characters="\ufffe\uffff"), max_size=8
    ),
    st.floats(-1e300, 1e300),
    st.integers(-(10**9), 10**9),
    st.datetimes(datetime(1950, 1, 1), datetime(2100, 1, 1)).map(lambda moment: moment.replace(microsecond=0)),
)


@pytest.mark.sampled
@given(st.lists(st.lists(CELLS, min_size=1, max_size=5), min_size=1, max_size=5))
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
def test_every_cell_of_a_workbook_arrives_where_it_is(rows: list[list[object]]) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    rows = [[*row, "end"] for row in rows]
    workbook = openpyxl.Workbook()
    for number, row in enumerate(rows, start=1):
        for column, value in enumerate(row, start=1):
            cell = workbook.active.cell(number, column, value)
            if isinstance(value, str):
                cell.data_type = "s"  # not a formula, whatever it starts with
    out = io.BytesIO()
    workbook.save(out)
    ((_, content),) = spreadsheet.sheets(out.getvalue())
    found = list(csv.reader(io.StringIO(content.decode(), newline="")))
    for row, cells in zip(rows, found, strict=True):
        for value, cell in zip(row, cells, strict=False):
            if isinstance(value, datetime):
                assert datetime.fromisoformat(cell) == value
            elif isinstance(value, int | float):
                assert float(cell) == pytest.approx(value, rel=1e-15)
            else:
                assert cell == (value or "")


def test_values_are_read_by_their_kind_and_not_as_shown() -> None:
    styles = (
        '<s><numFmts><numFmt numFmtId="170" formatCode="[h]:mm:ss"/><numFmt numFmtId="171"'
        ' formatCode="0 &quot;days&quot;"/>'
        '<numFmt numFmtId="172" formatCode="[$-409]d/m/yy;@"/></numFmts><cellStyleXfs>'
        '<xf numFmtId="14"/></cellStyleXfs>'
        + "<cellXfs>"
        + "".join(f'<xf numFmtId="{n}"/>' for n in (0, 14, 170, 171, 172, 21))
        + "</cellXfs></s>"
    )
    cells = "".join(f'<c s="{style}"><v>45780.5</v></c>' for style in range(5)) + '<c s="5"><v>0.42709</v></c>'
    cells += '<c t="b"><v>1</v></c><c t="e"><v>#N/A</v></c><c t="inlineStr"><is><r><t>a</t></r><r><t>b</t></r></is></c>'
    ((_, content),) = spreadsheet.sheets(xlsx(SHEET.format(cells), xl__styles=styles))
    day = "2025-05-03T12:00:00"
    assert content.decode() == f"45780.5,{day},1098732:00:00,45780.5,{day},10:15:00.576,True,,ab\n"
    values = {
        'value-type="float" o:value="1.50"': "1.5",
        'value-type="date" o:date-value="2025-05-03T10:15:00.25"': "2025-05-03T10:15:00.250",
        'value-type="date" o:date-value="2025-05-03"': "2025-05-03",
        'value-type="time" o:time-value="PT30H15M01.5S"': "30:15:01.500",
        'value-type="boolean" o:boolean-value="true"': "True",
        'value-type="string" o:string-value="other"': "other",
    }
    note = "<annotation><p>note</p></annotation>"
    body = "".join(f"<table-cell o:{value}>{note}<p>shown</p></table-cell>" for value in values)
    ((_, content),) = spreadsheet.sheets(archive(content=ODS.format(f"<table-row>{body}</table-row>")))
    assert content.decode() == ",".join(values.values()) + "\n"


def test_a_table_that_starts_in_another_column_keeps_the_empty_ones() -> None:
    rows = [[None, None, None], [None, "a", "b"], [None, 1.5, 2]]
    (found,) = spreadsheet.sheets(book(".xlsx", log=rows))
    assert found == ("log", b",,\n,a,b\n,1.5,2\n")


@pytest.mark.sampled
@pytest.mark.parametrize("kind", KINDS)
def test_a_large_spreadsheet_is_read_row_by_row(kind: str) -> None:
    """Only its text is in memory: a cell as an object would take 30 bytes, and its place in a list 8."""
    log = book(kind, log=[[n + 0.125] * 8 for n in range(4000)])
    tracemalloc.start()
    try:
        (found,) = spreadsheet.sheets(log)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2.5 * len(found[1]) + 500_000


def test_empty_rows_below_a_table_are_not_counted() -> None:
    empty = '<table-row o:number-rows-repeated="1048576"><table-cell o:number-columns-repeated="16384"/></table-row>'
    log = archive(content=ODS.format("<table-row><table-cell><p>1</p></table-cell></table-row>" + empty))
    assert list(spreadsheet.sheets(log)) == [("S", b"1\n")]
