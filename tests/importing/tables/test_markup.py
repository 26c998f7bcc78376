"""Tables of web pages and of XML workbooks, which programs save as `.xls`, are read like the same table as CSV."""

import html

import numpy as np
import pytest

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.importing import Reading
from fieldkit.importing.read import read
from fieldkit.importing.recognize import open_log
from fieldkit.importing.tables.spreadsheet import is_spreadsheet, sheets
from tests.samples import any_motor, samples_of

LOG = samples_of("mapped_table")[0].read_bytes()
ROWS = [line.split(",") for line in LOG.decode().split()]


def page(rows: list[list[str]]) -> str:
    """A table as a page shows it, with a table for its layout around it."""
    lines = ("".join(f"<td class=x>{html.escape(cell)}</td>" for cell in row) for row in rows)
    table = "".join(f"<tr>{line}</tr>\n" for line in lines)
    return f"<html><head><style>td {{}}</style></head><body><p>Log<table border=1>\n{table}</table></body></html>"


def workbook(rows: list[list[str]]) -> str:
    """A table as Excel 2003 writes it as XML; the number of a cell is stated after empty ones."""
    lines = (
        "".join(
            f'<Cell ss:Index="{place}"><Data ss:Type="String">{html.escape(cell)}</Data></Cell>'
            for place, cell in enumerate(row, start=1)
            if cell
        )
        for row in rows
    )
    table = "".join(f"<Row>{line}</Row>\n" for line in lines)
    head = '<?xml version="1.0"?>\n<?mso-application progid="Excel.Sheet"?>\n<Workbook xmlns:ss="urn:x">'
    return f'{head}<Worksheet ss:Name="Log"><Table>{table}</Table></Worksheet></Workbook>'


FORMS = {"page": page(ROWS).encode(), "UTF-16": page(ROWS).encode("utf-16"), "workbook": workbook(ROWS).encode()}


@pytest.mark.parametrize("form", FORMS)
def test_they_give_the_samples_of_the_csv(form: str) -> None:
    opened = [open_log(log, "log.xls", None).found for log in (LOG, FORMS[form])]
    expected, found = (next(one for one in items if isinstance(one, Reading)) for items in opened)
    for one, other in zip(expected.clocks, found.clocks, strict=True):
        for name in ("time", "altitude", "pressure"):
            assert np.array_equal(getattr(one, name), getattr(other, name))


def test_a_page_that_was_cut_off_gives_the_rows_before() -> None:
    whole = page(ROWS)
    [(_, content)] = sheets(whole[: len(whole) // 2].encode())
    found = [line.rstrip(",") for line in content.decode().split()]
    kept = len(ROWS) // 2 - 5
    assert found[:kept] == [",".join(row).rstrip(",") for row in ROWS[:kept]]


def test_numbers_are_as_stated_and_dates_as_shown() -> None:
    cells = '<td x:num="21.53418">21.5</td><td x:num="45822">14 June</td><td colspan=2>a&nbsp;b<br>c</td><td>d</td>'
    [(_, content)] = sheets(f"<table><tr>{cells}</tr></table>".encode())
    assert content.decode() == "21.53418,14 June,a b c,,d\n"


def test_each_table_of_a_page_is_a_sheet() -> None:
    log = b"<table><tr><td>1<table><tr><td>2</td></tr></table></td></tr></table><table><tr><td>3</table>"
    assert [content for _, content in sheets(log)] == [b"2\n", b"1\n", b"3\n"]


@pytest.mark.parametrize(
    "log", [b"<gpx><trkpt/></gpx>", b"<?xml version='1.0'?><RockSimDocument/>", b"time,altitude\n"]
)
def test_other_files_are_no_tables_of_pages(log: bytes) -> None:
    assert not is_spreadsheet(log)


def test_a_page_without_a_table_and_an_old_workbook_are_refused_by_name() -> None:
    with pytest.raises(DamagedLog, match=r"^log\.xls: found an empty spreadsheet"):
        read(b"<html><body>Not found</body></html>", "log.xls", any_motor)
    with pytest.raises(UnknownFormat, match=r"^log\.xls: .*save it as \.xlsx or CSV"):
        read(bytes.fromhex("d0cf11e0a1b11ae1") + bytes(512), "log.xls", any_motor)


@pytest.mark.parametrize("piece", [b"<table>", b"<table><tr><td>1</table>", b"x<table><td></table>", b"<td", b"<td <"])
def test_a_page_of_one_piece_over_and_over_takes_no_time(piece: bytes) -> None:
    with pytest.raises(DamagedLog):
        read(b"<html><table><tr><td>" + piece * 100_000, "log.xls", any_motor)
