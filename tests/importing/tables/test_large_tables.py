"""Large plain tables are read by pandas, with the same result as line by line."""

from itertools import product

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing.tables import large_tables
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.units import UNITS

CHANNELS = (
    Channel("time", 0, needed=True, header="t"),
    Channel("altitude", 2, UNITS["length"]["ft"], header="alt"),
    Channel("voltage", 1, header="v"),
)
CELLS = ("1.5", "-2", "1e3", "", "nan", "NaN", "None", "n/a", " 3 ", "x", "1_000", "inf", "1e40", "True", '"4"', "0x10")


def both(log: bytes, monkeypatch: pytest.MonkeyPatch, **settings: object) -> tuple[object, object]:
    """A log read line by line, and in blocks like a large one."""
    found = []
    for least in (1 << 40, 0):
        monkeypatch.setattr(large_tables, "LARGE_LOG", least)
        try:
            found.append(contents(read_columns(log, CHANNELS, after=1, **settings)))  # type: ignore[arg-type]
        except DamagedLog as error:
            found.append(str(error))
    return found[0], found[1]


def contents(table: LogTable) -> tuple[object, ...]:
    values = {name: [repr(one) for one in column.tolist()] for name, column in table.values.items()}
    return values, table.rows.tolist(), [str(item) for item in table.found]


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_any_cell_reads_the_same(cell: str, end: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for place in range(3):
        lines = [[f"{i}.25", "3.7", "100"] for i in range(9)]
        lines[4][place] = cell
        log = end.join(["t,v,alt", *map(",".join, lines), ""]).encode()
        one, other = both(log, monkeypatch)
        assert one == other


@pytest.mark.parametrize(
    "rows",
    [
        "1,2,3\n\n2,2,3\n",
        "1,2\n2,3,4\n",
        "1,2,3,4\n2,2,3\n",
        "\n1,2,3\n",
        "1,2,3\n2,2,",
        "1;2;3\n",
        "# no\n1,2,3\n",
        "",
    ],
)
@pytest.mark.parametrize("widths", [None, {3}])
def test_rows_of_any_form_read_the_same(rows: str, widths: set[int] | None, monkeypatch: pytest.MonkeyPatch) -> None:
    one, other = both(f"t,v,alt\n{rows}".encode(), monkeypatch, widths=widths)
    assert one == other


def test_decimal_commas_read_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    log = b"t;v;alt\n" + b"".join(b"%d,25;3,7;%d,5\n" % (i, i * 3) for i in range(400))
    one, other = both(log, monkeypatch, separator=";", decimal=",")
    assert one == other
    assert isinstance(one, tuple)
    assert len(one[1]) == 400


def test_blocks_end_with_lines_and_know_their_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(large_tables, "BLOCK", 50)
    random = np.random.default_rng(4)
    log = b"t,v,alt\n" + b"".join(b"%d,%.3f,%d\n" % (i, random.random(), i % 17) for i in range(200))
    bad = log.replace(b"\n120,", b"\nx20,")
    for text, widths in product((log, bad), (None, {3})):
        one, other = both(text, monkeypatch, widths=widths)
        assert one == other
