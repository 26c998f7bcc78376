"""Numbers from a table: every complete row and no others, with a line about each damaged one."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note
from fieldkit.importing.tables import rows, text
from fieldkit.importing.tables.clocks import onward
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.units import UNITS, Unit

pytestmark = pytest.mark.fast

CHANNELS = (Channel("time", 0, needed=True), Channel("altitude", 1, Unit(0.3048), header="Alt"))


def reported(table: LogTable) -> list[str]:
    return [f"note {item.row}" if isinstance(item, Note) else str(item) for item in table.found]


def test_numbers_are_in_si_and_rows_are_numbered_as_in_the_file() -> None:
    table = read_columns(b"Time,Alt\n0.0, 10\n\n0.1,20\n", CHANNELS, after=1)
    assert table.values["altitude"] == pytest.approx([3.048, 6.096])
    assert table.rows.tolist() == [2, 4]
    assert not table.found


def test_only_the_damaged_row_is_lost_and_its_fault_is_reported() -> None:
    log = b"Time,Alt\n0.0,10\n0.1,1o4\n0.2,20,5\n0.3,30\n,40\n0.5,inf\n0.6,50\n"
    table = read_columns(log, CHANNELS, after=1, widths={2})
    assert table.values["time"].tolist() == [0.0, 0.3, 0.6]
    assert reported(table) == [
        "row 3, Alt: found '1o4', expected a number",
        "row 4: found 3 cells, expected 2",
        "row 6, time: found '', expected a number",
        "row 7, Alt: found 'inf', expected a number",
    ]


@pytest.mark.parametrize("gap", ["", "  ", "NaN", "-", "None", "n/a"])
def test_a_missing_number_is_nan_and_not_damage(gap: str) -> None:
    table = read_columns(f"0,{gap},1\n1,5,2\n2,{gap},3\n".encode(), CHANNELS, after=0)
    assert np.isnan(table.values["altitude"]).tolist() == [True, False, True]
    assert not table.found


@pytest.mark.parametrize("cell", ["1_0", "٣", "0x10", "1,5", "--1", "1e999", "12 3", "5ft"])
def test_only_plain_numbers_are_read_as_numbers(cell: str) -> None:
    table = read_columns(f"0;1.5\n1;{cell}\n2;3\n".encode(), CHANNELS, after=0, separator=";")
    assert table.values["time"].tolist() == [0, 2]
    assert len(table.found) == 1


def test_a_truncated_last_row_gives_a_note() -> None:
    assert reported(read_columns(b"0,10\n0.1,20\n0.", CHANNELS, after=0, widths={2})) == ["note 3"]
    assert reported(read_columns(b"0,10\n0.1,20\n0.\n", CHANNELS, after=0, widths={2})) != ["note 3"]


def test_units_inside_cells_must_be_those_expected() -> None:
    hot = Channel("temperature", 1, UNITS["temperature"]["f"], suffix="F")
    table = read_columns(b"0,32F\n1,50.0 F\n2,10C\n3,\n", (CHANNELS[0], hot), after=0)
    assert table.values["temperature"] == pytest.approx([273.15, 283.15, np.nan], nan_ok=True)
    assert reported(table) == ["row 3, temperature: found '10C', expected a number with F"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_any_encoding_and_line_end_give_the_same_numbers(encoding: str, end: str) -> None:
    text = end.join(["Temps;Höhe;wo", "0,5;10;a", "1,5;20;ü", "1,5;20;ü", ""])
    table = read_columns(
        text.encode(encoding) + bytes(8), CHANNELS, after=1, separator=";", decimal=",", words={"w": 2}
    )
    assert table.values["time"].tolist() == [0.5, 1.5, 1.5]
    assert table.where("w", "a").tolist() == [0]
    assert not table.found


def test_text_and_comments_are_kept_with_their_rows() -> None:
    log = b"0,1,-\n0.1,2,-\n# Event APOGEE occurred at t=0.1 seconds\n0.2,3,Drogue\nx,3,-\n"
    table = read_columns(log, CHANNELS, after=0, words={"event": 2}, comment="#")
    assert table.where("event", "Drogue").tolist() == [2]
    assert table.where("event", "Main").tolist() == []
    assert table.remarks == ((3, "# Event APOGEE occurred at t=0.1 seconds"),)
    assert len(table.found) == 1


def test_cells_may_be_separated_by_spaces() -> None:
    table = read_columns(b"  0   10\n1\t20  \n2 -\n", CHANNELS, after=0, separator=None, widths={2})
    assert table.values["altitude"] == pytest.approx([3.048, 6.096, np.nan], nan_ok=True)


@pytest.mark.sampled
@pytest.mark.parametrize("line", ['"a"b,1\n', '"a,1\n', 'a","x\n'])
def test_unmatched_quotation_marks_take_time_in_proportion_to_the_table(line: str) -> None:
    def seconds(lines: int) -> float:
        start = time.process_time()
        assert list(text.rows("rocket,apogee\n" + lines * line, ","))
        return time.process_time() - start

    assert seconds(80_000) < 8 * max(seconds(20_000), 0.02)


def test_the_rest_of_a_table_of_unmatched_quotation_marks_is_refused() -> None:
    *_, (last, damaged) = text.rows("rocket,apogee\n" + 1000 * 'a","x\n', ",")
    assert last < 100
    assert "the rest is not read" in str(damaged)


def test_a_stray_quotation_mark_loses_one_row() -> None:
    table = read_columns(b'"0","10"\n1,"20\n2,30\n3,40\n', CHANNELS, after=0)
    assert table.values["time"].tolist() in ([0, 2, 3], [0, 1, 2, 3])


def test_an_overlong_line_loses_one_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "BLOCK", 64)
    table = read_columns(b"0,1\n" + b"7" * 500 + b"\n2,3\n", CHANNELS, after=0)
    assert table.values["time"].tolist() == [0, 2]
    assert reported(table) == ["row 2: found an endless line or a NUL character, expected a row"]


def test_many_damaged_rows_are_reported_as_one() -> None:
    log = b"".join(b"%d,1\nx,1\n" % i for i in range(500))
    table = read_columns(log, CHANNELS, after=0)
    assert len(table) == 500
    assert reported(table)[rows.MAX_REPORTED :] == ["found 480 more damaged rows"]


def test_an_overlong_table_is_thinned_evenly_and_reports_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "BLOCK", 256)
    monkeypatch.setattr(rows, "MOST_NUMBERS", 2000)
    log = b"".join(b"%d,1,%s\n" % (i, b"Main" if i == 3777 else b"-") for i in range(5000))
    table = read_columns(log, CHANNELS, after=0, words={"event": 2})
    assert len(table) * 4 <= 2000
    assert table.values["time"][table.where("event", "Main")].tolist() == [3777]
    steps = np.diff(np.delete(table.values["time"], [*table.where("event", "Main"), *table.where("event", "Main") + 1]))
    assert (steps[:-1] <= 24).all()
    assert reported(table) == ["note None"]


def test_a_table_without_readable_rows_is_a_damaged_log() -> None:
    for log in (b"", b"\0" * 100, b"Time,Alt\n", b"Time,Alt\nx,y\n"):
        with pytest.raises(DamagedLog):
            read_columns(log, CHANNELS, after=1)


def test_rows_out_of_order_are_left_out_and_reported() -> None:
    parts, found = read_columns(b"0,1\n1,1\n912,1\n2,1\n3,1\n0.5,1\n4,1\n", CHANNELS, after=0).flights()
    assert [part.values["time"].tolist() for part in parts] == [[0, 1, 2, 3, 4]]
    assert [str(error) for error in found] == [
        "row 3: found time 912 out of order, expected it to increase",
        "row 6: found time 0.5 out of order, expected it to increase",
    ]


def test_a_time_days_away_does_not_belong_to_the_flight() -> None:
    parts, found = read_columns(b"0,1\n1,1\n2,1\n3,1\n9999999999,1\n", CHANNELS, after=0).flights()
    assert parts[0].values["time"].tolist() == [0, 1, 2, 3]
    assert len(found) == 1


def test_if_a_clock_is_set_during_the_log_one_of_its_times_is_kept() -> None:
    parts, _ = read_columns(b"0,1\n1,1\n1700000000,1\n1700000001,1\n", CHANNELS, after=0).flights()
    assert len(parts[0]) == 2


def test_a_clock_that_restarts_begins_another_flight() -> None:
    first, second = (b"".join(b"%d,%d\n" % (t, t * slope) for t in range(8)) for slope in (1, 2))
    parts, found = read_columns(first + second + first, CHANNELS, after=0).flights()
    assert [part.rows.tolist() for part in parts] == [list(range(1, 9)), list(range(9, 17))]
    assert found == [Note("repeats an earlier flight of this file, imported once", 17)]


def test_a_block_that_was_written_twice_begins_no_flight() -> None:
    rows = [b"%d,%d\n" % (t, t * t) for t in range(30)]
    parts, found = read_columns(b"".join(rows[:20] + rows[12:]), CHANNELS, after=0).flights()
    assert [part.values["time"].tolist() for part in parts] == [list(range(30))]
    assert found == [Note("repeats 8 rows, read once", 21)]


@pytest.mark.parametrize("pieces", [2, 10, 400])
def test_a_recording_written_in_mixed_pieces_is_put_in_order(pieces: int) -> None:
    """A ring buffer that wrapped, blocks of a flash memory, and rows each by itself."""
    rng = np.random.default_rng(2)
    blocks = np.array_split(np.arange(400), pieces)
    order = np.concatenate(blocks[::-1] if pieces == 2 else [blocks[place] for place in rng.permutation(pieces)])
    log = b"".join(b"%d,%d\n" % (place, 2 * place) for place in order)
    (part,), found = read_columns(log, CHANNELS, after=0).flights()
    assert part.values["time"].tolist() == list(range(400))
    assert part.rows.tolist() == (np.argsort(order) + 1).tolist()
    assert [note.text for note in found if isinstance(note, Note)] == ["has rows out of order, sorted by its clock"]


def test_two_flights_whose_clocks_begin_again_are_not_mixed() -> None:
    first, second = (b"".join(b"%.2f,%d\n" % (0.1 * t + late, t) for t in range(60)) for late in (0.0, 0.04))
    parts, found = read_columns(first + second, CHANNELS, after=0).flights()
    assert [len(part) for part in parts] == [60, 60]
    assert not found


@given(st.lists(st.integers(0, 9), min_size=1, max_size=40))
def test_a_monotonic_selection_never_runs_backwards_and_could_not_be_longer(clock: list[int]) -> None:
    kept = onward(np.array(clock, float))
    assert (np.diff(np.array(clock)[kept]) >= 0).all()
    best = [1] * len(clock)
    for i, value in enumerate(clock):
        best[i] += max((best[j] for j in range(i) if clock[j] <= value), default=0)
    assert kept.sum() == max(best)


@given(
    st.lists(
        st.tuples(st.sampled_from(["0", "1.5", "-2e3", "", "nan", "x", "-", " 7 ", '"8"', "1;2"]), st.integers(0, 9)),
        max_size=60,
    )
)
def test_blocks_are_read_like_single_rows(cells: list[tuple[str, int]]) -> None:
    def values(lines: list[str]) -> list[tuple[float, float]]:
        try:
            table = read_columns("".join(lines).encode(), CHANNELS, after=0, widths={2})
        except DamagedLog:
            return []
        return list(zip(table.values["time"], np.nan_to_num(table.values["altitude"], nan=-1.0), strict=True))

    lines = [f"{time},{cell}\n" for cell, time in cells]
    assert values(lines) == [row for line in lines for row in values([line])]


def test_a_header_that_stands_again_is_no_row_and_numbers_above_a_table_are_not_a_header() -> None:
    log = b"0,0\ntime,height\n0,0\n0,0\n1,5\ntime,height\n2,9\n"
    table = read_columns(log, [Channel("time", 0), Channel("height", 1)], after=2)
    assert table.values["height"].tolist() == [0.0, 0.0, 5.0, 9.0]
    assert not table.found
