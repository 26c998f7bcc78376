"""The flight table: the meaning of its cells, and exported tables import unchanged."""

import csv
import io
from datetime import datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.errors import DamagedLog, FieldkitError, UnknownFormat
from fieldkit.flight import BY_NAME, COLUMNS, TAGS, TEXT_COLUMNS, Flight
from fieldkit.flight.limits import LIMITS
from fieldkit.importing import ImportedFile, Mapped, Reading
from fieldkit.importing.read import read, read_plans
from fieldkit.importing.recognize import claims, open_log
from fieldkit.importing.tables import flight_headings
from fieldkit.importing.tables.flight_headings import role_of, shape
from fieldkit.importing.tables.mapping import read_choice
from fieldkit.presentation.export import csv_table
from tests.effort import examples
from tests.samples import any_motor

pytestmark = pytest.mark.fast


def imported(text: str, format: str | None = None) -> ImportedFile:
    return read(text.encode(), "t.csv", any_motor, format)


def flight(header: str, row: str) -> Flight:
    """The flight of a valid table with one row."""
    got = imported(f"{header}\n{row}\n")
    assert not got.rejected, got.rejected
    (only,) = got.flights
    return only


def complaint(header: str, row: str) -> str:
    """The message about the only bad row of a table."""
    got = imported(f"{header}\n{row}\n")
    assert not got.flights
    (rejected,) = got.rejected
    assert rejected.row == 2
    return f"{rejected.column}: {rejected.error}"


@pytest.mark.parametrize(
    ("header", "cell", "si"),
    [
        ("apogee_m", "281.3", 281.3),
        ("APOGEE_FT", "923", 281.3304),
        ("Apogee (ft)", "923", 281.3304),
        ("apogee_m", "923ft", 281.3304),
        ("apogee_m", " 923 Ft ", 281.3304),
        ("apogee", "281.3 m", 281.3),
        ("top_speed_kph", "36", 10),
        ("top_speed_fps", "100", 30.48),
        ("top speed [m/s]", "30.48", 30.48),
        ("dry_mass_oz", "11.358", 0.321994),
        ("dry_mass_lb", "1", 0.45359237),
        ("dry_mass_kg", "0.322", 0.322),
        ("peak_accel_mps2", "9.80665", 9.80665),
        ("peak_accel_g", ".5", 4.903325),
        ("diameter_in", "2.6", 0.06604),
        ("diameter_cm", "6.6", 0.066),
        ("temperature_f", "68", 293.15),
        ("temperature_°C", "-3", 270.15),
        ("pressure_inhg", "29.92", 101320.76),
        ("humidity_%", "45", 0.45),
        ("rail_angle_deg", "5", 0.0872665),
        ("apogee_to_eject_s", "-.1", -0.1),
    ],
)
def test_a_number_is_read_in_the_unit_of_its_header_or_its_cell(header: str, cell: str, si: float) -> None:
    got = flight(f"rocket,duration_s,{header}", f"Swift,30,{cell}")
    (name,) = (n for n in BY_NAME if n != "duration" and got.number(n) is not None)
    assert got.number(name) == pytest.approx(si, rel=1e-5)


@pytest.mark.parametrize("cell", ["", "  ", "-", "–", "n/a", "N/A", "none"])
def test_an_empty_cell_is_not_recorded_and_never_zero(cell: str) -> None:
    assert flight("rocket,apogee_m,wind_mps", f"Swift,100,{cell}").wind is None


@pytest.mark.parametrize(
    "cell", ["nan", "NaN", "inf", "-inf", "-5", "0", "1e9", "1e999", "1o4", "12.3.4", "1_000", "12 furlong"]
)
def test_an_impossible_apogee_is_refused_with_its_column(cell: str) -> None:
    assert complaint("rocket,Apogee_M", f"Swift,{cell}").startswith("Apogee_M: found ")


@pytest.mark.parametrize("column", COLUMNS, ids=lambda column: column.name)
def test_every_columns_bounds_are_wider_than_its_usual_range(column: object) -> None:
    known = BY_NAME[column.name]  # type: ignore[attr-defined]
    low, high = LIMITS[known.name]
    assert known.parse(str(low)) <= known.low + 1e-9
    assert known.parse(str(high)) >= known.high - 1e-9


def test_an_unusual_value_is_read_with_a_note() -> None:
    got = imported("rocket,apogee_m\nSwift,3\n")
    assert got.flights[0].apogee == 3
    assert got.notes == ("t.csv, row 2: apogee 3 m is unusual, expected 5 to 10000 m",)


@pytest.mark.parametrize(
    ("table", "apogee"),
    [
        ("rocket;apogee_m\nSwift;281,3\n", 281.3),
        ("rocket;apogee_m\nSwift;281.3\n", 281.3),
        ("rocket\tapogee_m\nSwift\t281,3\n", 281.3),
        ('rocket,apogee_m\nSwift,"281,3"\n', 281.3),
        ("rocket;apogee_m;wind_mps\nSwift;11,358;2\n", 11.358),
        ("rocket\tapogee_m\twind_mps\nSwift\t11,358\t2,5\n", 11.358),
        ("rocket,apogee_m\nSwift,11.358\n", 11.358),
    ],
)
def test_the_decimal_mark_is_inferred_from_the_whole_table(table: str, apogee: float) -> None:
    assert imported(table).flights[0].apogee == pytest.approx(apogee)


@pytest.mark.parametrize(
    "table",
    [
        'rocket,apogee_m\nSwift,"1,148"\n',
        "rocket\tapogee_m\nSwift\t1,148\n",
        'rocket,apogee_m,wind_mps\nSwift,"1,148",2.5\n',
        "rocket;apogee_m;wind_mps\nSwift;1.148;2,5\n",
        "rocket;apogee_m;wind_mps\nSwift;1,148;2.5\n",
        "rocket;apogee_m;wind_mps\nSwift;1,148;1.148\n",
    ],
)
def test_a_number_that_may_be_a_thousand_or_a_decimal_is_refused(table: str) -> None:
    got = imported(table)
    assert not got.flights
    assert "which may be 1148 or 1.148" in got.rejected[0].error


@pytest.mark.parametrize(
    ("table", "apogee"),
    [
        ('rocket,apogee_ft\nSwift,"5,612"\n', 1710.5376),
        ('rocket,Max Alt (ft),wind_mps\nSwift,"5,612",2.5\n', 1710.5376),
        ('rocket,apogee_m\nSwift,"5,612 ft"\n', 1710.5376),
        ("rocket;apogee_ft;wind_mps\nSwift;1,148;2,5\n", 1.148 * 0.3048),
    ],
)
def test_a_comma_separates_thousands_of_feet_unless_the_table_has_decimal_commas(table: str, apogee: float) -> None:
    (only,) = imported(table).flights
    assert only.apogee == pytest.approx(apogee)


def test_unknown_columns_stay_with_the_flight_under_their_own_names() -> None:
    got = flight("rocket,apogee_m,Lot No.,wind_direction,apogee_gps_m", "Swift,100, A7 ,NW,101")
    assert got.extra == {"Lot No.": " A7 ", "wind_direction": "NW", "apogee_gps_m": "101"}


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (
            "apogee_m,apogee_sd_m,apogee_sd_ft",
            "t.csv, row 1, apogee_sd_ft: found a second column that means the same as apogee_sd_m",
        ),
        (
            "rocket,apogee_furlong",
            "t.csv, row 1, apogee_furlong: found the unit 'furlong', expected one of m, mm",
        ),
        (
            "rocket,dry_mass_mm,apogee_m",
            "t.csv, row 1, dry_mass_mm: found the unit 'mm', expected one of kg, g",
        ),
    ],
)
def test_a_table_with_an_ambiguous_header_is_refused(header: str, message: str) -> None:
    with pytest.raises(DamagedLog, match=f"^{message}"):
        imported(f"{header}\nSwift,1,1,1\n")


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("rocket,apogee_m,apogee_m,rocket", "Swift,281.3,281.3,Swift"),
        ("rocket,apogee_m,Apogee (ft)", "Swift,281.3,923"),
        ("rocket,apogee_ft,apogee_m", "Swift,,281.3"),
        ("rocket,apogee_m,apogee_ft,lot,LOT", "Swift,281,922.8,A,A"),
        ("rocket,apogee_m,apogee_ft", "Swift,281.3,"),
    ],
)
def test_a_duplicate_column_is_read_once(header: str, row: str) -> None:
    got = flight(header, row)
    assert got.rocket == "Swift"
    assert got.apogee == pytest.approx(281.3, abs=0.31)


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("rocket,apogee_m,apogee_ft", "Swift,281.3,950", "apogee_ft: found '950', expected the value in the column"),
        ("rocket,apogee_m,rocket", "Swift,281.3,Kestrel", "rocket: found 'Kestrel', expected the value in the column"),
        ("rocket,apogee_m,lot,LOT", "Swift,281.3,A,B", "LOT: found 'B', expected the value in the column 'lot'"),
    ],
)
def test_for_a_duplicate_column_with_different_values_both_are_named(header: str, row: str, message: str) -> None:
    assert message in complaint(header, row)


def test_another_column_for_a_quantity_besides_the_one_with_a_unit_is_kept() -> None:
    assert flight("rocket,apogee_m,apogee_gps", "Swift,100,x").extra == {"apogee_gps": "x"}


@pytest.mark.parametrize(
    "header", ["time,altitude", "temperature_c,pressure_hpa", "published_apogee_m,x", "Duration,Apogee"]
)
def test_a_table_without_a_known_column_is_not_recognized(header: str) -> None:
    with pytest.raises((UnknownFormat, DamagedLog)):  # a clock and a height may be another kind of log
        imported(f"{header}\n1,2\n")
    assert "flight_table" not in claims(f"{header}\n1,2\n".encode())


def test_a_forced_table_without_any_known_column_says_what_is_missing() -> None:
    with pytest.raises(
        DamagedLog, match="row 1: found no column of the flight table, expected at least one of flight_id"
    ):
        imported("time,altitude\n1,2\n", format="flight_table")


def test_a_header_without_rows_gives_no_flights_and_is_reported() -> None:
    got = imported("rocket,apogee_m\n")
    assert (got.flights, got.rejected, got.notes) == (
        (),
        (),
        ("t.csv, row 1: found a header and no flights",),
    )


@pytest.mark.parametrize(
    ("cell", "date"),
    [
        ("2026-05-01", datetime(2026, 5, 1)),
        ("2026-05-01 10:30", datetime(2026, 5, 1, 10, 30)),
        ("2026-05-01T10:30:05", datetime(2026, 5, 1, 10, 30, 5)),
        ("2026-05-01T10:30+02:00", datetime(2026, 5, 1, 10, 30)),
        ("", None),
        ("01.05.2026", datetime(2026, 5, 1)),
        ("2026/5/1", datetime(2026, 5, 1)),
        ("2026.05.01 10:30", datetime(2026, 5, 1, 10, 30)),
        ("5/13/2026 2:05 PM", datetime(2026, 5, 13, 14, 5)),
        ("13-05-2026", datetime(2026, 5, 13)),
        ("5/13/99", datetime(1999, 5, 13)),
        ("5/13/12", datetime(2012, 5, 13)),
        ("1 May 2026 10:30 AM", datetime(2026, 5, 1, 10, 30)),
        ('"Fri, May 1st, 2026"', datetime(2026, 5, 1)),
        ("Sept. 3 2026", datetime(2026, 9, 3)),
    ],
)
def test_dates_are_in_local_time_and_in_any_unambiguous_spelling(cell: str, date: datetime | None) -> None:
    assert flight("rocket,apogee_m,date_time", f"Swift,100,{cell}").date_time == date


@pytest.mark.parametrize(
    "cell", ["5/1/2026", "5-1-2026", "2026-13-01", "2026/13/1", "31.4.2026", "2026-02-30", "10:30", "noon"]
)
def test_other_dates_are_refused_with_their_column(cell: str) -> None:
    assert complaint("rocket,apogee_m,date_time", f"Swift,100,{cell}").startswith("date_time: found ")


def test_tags_are_separated_by_semicolon_bar_or_comma_and_known_ones_are_recognized() -> None:
    got = flight("rocket,apogee_m,tags", 'Swift,100,"Weak launch; off-axis|my tag,,weak_launch"')
    assert got.tags == ("weak_launch", "off_axis", "my tag")
    assert not got.clean


def test_a_row_that_is_not_a_flight_is_refused_and_the_others_are_imported() -> None:
    got = imported("flight_id,rocket,apogee_m,log\n1,Swift,100,\n2,Swift,,\n\n3,Swift,,log3.csv\n ,,,\n4,Swift,90\n")
    assert [f.flight_id for f in got.flights] == ["1", "3", "4"]
    assert [(r.row, r.error.split(",")[0]) for r in got.rejected] == [(3, "found no readout")]


def test_a_row_longer_than_the_header_is_refused_unless_the_rest_is_empty() -> None:
    assert "found 3 cells, expected at most 2, one for each header" in complaint("rocket,apogee_m", "Swift,281,3")
    assert flight("rocket,apogee_m", "Swift,281,,").apogee == 281


def test_a_file_that_ends_within_a_row_loses_only_that_row() -> None:
    got = imported("rocket,apogee_m,duration_s\nSwift,100,30\nSwift,28")
    assert [f.apogee for f in got.flights] == [100]
    assert got.rejected[0].row == 3


def test_a_quotation_mark_that_is_never_closed_loses_one_row() -> None:
    got = imported('rocket,apogee_m,notes\nSwift,100,"open\nSwift,110,fine\nSwift,120,"two\nlines"\nSwift,130,\n')
    assert [f.apogee for f in got.flights] == [110, 120, 130]
    assert [r.row for r in got.rejected] == [2]
    assert got.flights[1].notes == "two\nlines"


def test_an_endless_cell_is_refused_as_such() -> None:
    got = imported(f"rocket,apogee_m\nSwift,{'1' * 200_000}\nSwift,100\n")
    assert "apogee_m" in (got.rejected[0].column or "")
    assert len(got.rejected[0].error) < 300
    assert len(got.flights) == 1


def test_long_notes_are_read_completely() -> None:
    got = imported(f"rocket,apogee_m,notes\nSwift,100,{'a long day ' * 20_000}\n")
    assert len(got.flights[0].notes) > 200_000


def test_rows_are_numbered_as_in_a_spreadsheet() -> None:
    got = imported('rocket,apogee_m,notes\nSwift,100,"two\nlines"\n\nSwift,x,\n')
    assert [r.row for r in got.rejected] == [4]


def test_a_duplicate_name_is_refused_and_a_repeated_row_is_not() -> None:
    got = imported("flight_id,rocket,apogee_m\n1,Swift,100\n1,Swift,100\n1,Plover,100\n1,Swift,90\n")
    assert [(f.flight_id, f.rocket) for f in got.flights] == [("1", "Swift"), ("1", "Plover")]
    assert [(r.row, r.column) for r in got.rejected] == [(5, "flight_id")]
    assert got.notes == ("t.csv, row 3: repeats row 2",)


TABLE = "rocket;apogee_m;notes\nWürger;281,3;½ µ\n"


@pytest.mark.parametrize(
    "log",
    [
        TABLE.encode(),
        TABLE.encode("utf-8-sig"),
        TABLE.encode("utf-16"),
        b"\xff\xfe" + TABLE.encode("utf-16-le"),
        b"\xfe\xff" + TABLE.encode("utf-16-be"),
        b"\xef\xbb\xbf" + TABLE.encode("utf-16-le"),
        TABLE.encode("cp1252"),
        TABLE.replace("\n", "\r\n").encode() + b"\0" * 600,
        TABLE.replace("\n", "\r").encode(),
    ],
)
def test_all_common_encodings_give_the_same_flights(log: bytes) -> None:
    (got,) = read(log, "t.csv", any_motor).flights
    assert (got.rocket, got.apogee, got.notes) == ("Würger", 281.3, "½ µ")


def test_a_typographic_minus_is_read_in_numbers_and_kept_in_notes() -> None:
    note = "lost 5 − 3 fins − and a 10 − 0 win −"
    got = flight(
        "flight_id,rocket,motor,apogee_m,temperature_c,apogee_to_eject_s,notes", f"1,Astra,F24-4W,281,−4,−.5,{note}"
    )
    assert (got.temperature, got.apogee_to_eject, got.notes) == (269.15, -0.5, note)


READ_AS_OTHERS = "\0\N{MINUS SIGN}"
"""Characters of a text that a table does not keep: a minus sign before a digit is read as a hyphen, as in numbers."""
name = st.text(st.characters(exclude_categories=["Cs"], exclude_characters=READ_AS_OTHERS), max_size=12).map(str.strip)
unknown = name.filter(lambda s: s and not any(s.lower().startswith(n[:4]) for n in (*BY_NAME, *TEXT_COLUMNS)))
odd_text = st.text(st.characters(exclude_categories=["Cs"], exclude_characters=READ_AS_OTHERS), max_size=30)
a_tag = st.sampled_from(sorted(TAGS)) | name.filter(lambda t: t and t.isalpha() and t.lower() not in TAGS)


@st.composite
def flights(draw: st.DrawFn, extra: tuple[str, ...]) -> Flight:
    """A flight as a flyer could enter it: numbers with a few decimals, texts of any kind."""
    numbers = {}
    for column in COLUMNS:
        low, high = LIMITS[column.name]
        value = draw(st.none() | st.floats(low, high).map(lambda x: round(x, 4)))
        if value is not None and low <= value <= high:
            numbers[column.name] = column.parse(repr(value) if abs(value) >= 1e-3 else f"{value:.6f}")
    numbers["apogee"] = 100.0
    kept = {key: text for key in extra if (text := draw(odd_text)).strip()}
    texts = {n: draw(name) for n in ("rocket", "config", "site", "log")}
    when = draw(st.none() | st.datetimes(datetime(1950, 1, 1)))
    tags = tuple(dict.fromkeys(draw(st.lists(a_tag, max_size=3))))
    given_texts: dict[str, object] = {
        **texts,
        **numbers,
        "motor": "C6-5",
        "notes": draw(odd_text),
        "extra": kept,
    }
    return Flight(flight_id=draw(name.filter(bool))).with_changes(date_time=when, tags=tags, **given_texts)


@examples(30)
@given(data=st.data())
def test_an_exported_flight_imports_as_the_same_flight(data: st.DataObject) -> None:
    extra = tuple(data.draw(st.lists(unknown, max_size=2, unique_by=str.lower)))
    key = lambda f: (f.rocket, f.flight_id)  # noqa: E731
    out = data.draw(st.lists(flights(extra), min_size=1, max_size=3, unique_by=key))
    rows = csv.reader(io.StringIO(csv_table(out), newline=""))
    table = io.StringIO(newline="")
    csv.writer(table, delimiter=data.draw(st.sampled_from(",;\t"))).writerows(rows)
    got = read(table.getvalue().encode(), "t.csv", any_motor)
    assert not got.rejected
    assert list(got.flights) == out


def test_the_reference_flights_are_read_completely() -> None:
    from importlib.resources import files

    table = (files("fieldkit") / "data" / "reference_flights.csv").read_bytes()
    got = read(table, "reference_flights.csv", any_motor)
    assert sum(f.apogee or 0 for f in got.flights) == pytest.approx(2345.7)
    assert [f.flight_id for f in got.flights if not f.clean] == ["5", "6", "7", "8"]
    assert not got.notes
    assert len(read_plans(table, "reference_flights.csv", any_motor)) == 12


@pytest.mark.parametrize(
    ("cells", "found"),
    [
        ("wind_aloft_mps", "wind aloft: found 'sideways'"),
        ("main_altitude_m", "main altitude: found 'sideways'"),
        ("stability_cal", "stability cal: found 'sideways'"),
        ("motor_temperature_c", "motor temperature: found 'sideways'"),
        ("rail_angle_deg,rail_direction", "rail_direction: found 'sideways'"),
    ],
)
def test_a_plan_that_cannot_be_read_is_named_by_its_row(cells: str, found: str) -> None:
    typed = "5,sideways" if "," in cells else "sideways"
    table = f"flight_id,motor,{cells}\n1,C6-5,{typed.replace('sideways', '3')}\n2,C6-5,{typed}\n"
    with pytest.raises(DamagedLog, match=f"plans.csv, row 3: {found}"):
        read_plans(table.encode(), "plans.csv", any_motor)


@pytest.mark.parametrize("name", ["flight_id", "rocket", "config", "site"])
def test_a_plan_with_a_name_that_no_table_shows_is_refused(name: str) -> None:
    table = f"motor,{name}\nC6-5,fine\nC6-5,{'x' * 100_000}\n"
    with pytest.raises(DamagedLog, match=f"plans.csv, row 3, {name}: found 'xxx.*expected at most 200") as refused:
        read_plans(table.encode(), "plans.csv", any_motor)
    assert len(str(refused.value)) < 200


def test_columns_with_common_other_names_are_read_and_not_kept_as_extra() -> None:
    one = flight(
        "Rocket name,Engine,Wind speed (mph),Max altitude (ft),Flight duration (s),Rod_length_m,Mood",
        "Swift,C6-5,10,1000,61.5,1.2,fine",
    )
    assert (one.rocket, one.motor, one.duration, one.rail_length) == ("Swift", "C6-5", 61.5, 1.2)
    assert one.wind == pytest.approx(4.4704)
    assert one.apogee == pytest.approx(304.8)
    assert one.extra == {"Mood": "fine"}


def test_a_column_with_its_standard_name_is_never_replaced_by_another() -> None:
    one = flight("rocket,motor,apogee_m,max_altitude_m,wind_speed_mps", "Swift,C6-5,300,310,2")
    assert (one.apogee, one.wind) == (300.0, 2.0)
    assert one.extra == {"max_altitude_m": "310"}


def test_a_name_without_its_unit_requires_one_in_the_cell() -> None:
    assert flight("rocket,motor,max_altitude", "Swift,C6-5,300m").apogee == 300.0


def test_a_table_with_only_other_names_is_a_table_of_flights() -> None:
    assert claims(b"Engine,Max altitude (ft)\nC6-5,1000\n") == ["flight_table"]
    assert claims(b"Time (s),Max altitude (ft)\n0,1000\n") != ["flight_table"]


def test_a_table_without_headers_is_mapped_by_number_and_recognized_by_its_shape() -> None:
    rows = b"2024-05-01,Astra,F24-4W,251,410\n2024-05-02,Astra,F24-4W,797 ft,415\n"
    chosen = read_choice(["date_time=#1", "rocket=#2", "motor=#3", "apogee=#4 [m]", "dry_mass=#5 [g]"])
    opened = open_log(rows, "bare.csv", None, [chosen])
    assert opened.format == "flight_table"
    (mapped,) = (item for item in opened.found if isinstance(item, Mapped))
    assert mapped.choice.headers == ("#1 date", "#2 text", "#3 text", "#4 number", "#5 number")
    assert [item.stated["apogee"] for item in opened.found if isinstance(item, Reading)] == [
        251.0,
        pytest.approx(797 * 0.3048),
    ]
    later = open_log(b"2024-06-01,Astra,F24-4W,222,410\n", "later.csv", None, [mapped.choice])
    (only,) = (item for item in later.found if isinstance(item, Reading))
    assert (only.stated["apogee"], only.stated["dry_mass"]) == (222.0, pytest.approx(0.41))
    with pytest.raises(FieldkitError):  # another shape
        open_log(b"Astra,2024-06-01,F24-4W,222,410\n", "other.csv", None, [mapped.choice])


@pytest.mark.parametrize(
    "header", ["date_time,rocket,motor,apogee_m", "Date,Rocket 2,Motor,Height 1", "flight,F24-4W,E35-5W"]
)
def test_headers_are_not_taken_for_a_row_of_a_table_without_headers(header: str) -> None:
    assert shape(header.split(",")) == ()


def test_a_launch_list_from_another_program_is_a_table_of_flights() -> None:
    table = (
        "launch_no;engine;liftoff_mass_g;wind_speed_mps;altitude_m;flight_time_s;date\n"
        "1;F39-6T;650;2,5;245,3;44,1;01.05.2024\n"
    )
    got = imported(table)
    (flight,) = got.flights
    assert (flight.flight_id, flight.motor, flight.apogee, flight.duration) == ("1", "F39-6T", 245.3, 44.1)
    assert flight.wind == 2.5
    assert flight.date_time is not None
    assert flight.date_time.date().isoformat() == "2024-05-01"
    assert flight.dry_mass is not None
    assert 0.55 < flight.dry_mass < 0.62
    assert "liftoff_mass" in {column.channel for column in got.recognition.columns}


@pytest.mark.parametrize(
    ("name", "field"),
    [("Engine used", "motor"), ("Motor used", "motor"), ("Lift off mass less motor (oz)", "dry_mass")],
)
def test_of_several_other_names_the_longest_is_meant(name: str, field: str) -> None:
    """Otherwise `Engine used` is the column `engine` in the unit `used`."""
    assert role_of(name, strict=True).field == field


def test_a_peak_in_feet_beside_a_motor_is_the_apogee() -> None:
    (flight,) = read(b"Engine used,Peak (ft),Max speed (mph)\nC6-5,512,80\n", "t.csv", any_motor).flights
    assert flight.apogee == pytest.approx(156.06, abs=0.01)
    assert flight.top_speed == pytest.approx(35.76, abs=0.01)


@pytest.mark.parametrize("name", ["Time (s)", "Time (sec)", "Time (seconds)"])
def test_a_time_in_seconds_beside_a_motor_is_the_duration(name: str) -> None:
    (flight,) = imported(f"Date,Motor,Altitude (ft),{name}\n2026-09-05,F42-8T,800,41.2\n").flights
    assert flight.duration == 41.2


def test_a_time_of_day_beside_a_motor_is_no_duration() -> None:
    (flight,) = imported("Date,Time,Motor,Altitude (ft)\n2026-09-05,14:05,F42-8T,800\n").flights
    assert flight.duration is None


@pytest.mark.parametrize("motor", ["homemade", ""])
def test_a_lift_off_mass_with_an_unknown_motor_is_kept_unchanged(motor: str) -> None:
    (flight,) = imported(f"engine,liftoff_mass_g,altitude_m\n{motor},650.5,245.3\n").flights
    assert flight.dry_mass is None
    assert flight.extra["liftoff_mass_g"] == "650.5"


def test_a_cluster_is_subtracted_from_a_lift_off_mass() -> None:
    one, two = (
        imported(f"engine,liftoff_mass_g,altitude_m\n{motor},250,245.3\n").flights[0].dry_mass or 0.0
        for motor in ("C6-5", "2 x C6-5")
    )
    assert 0.25 - two == pytest.approx(2 * (0.25 - one))


def test_an_ambiguous_date_of_a_list_is_kept_as_text() -> None:
    (flight,) = imported("Motor,Altitude (ft),Date\nC6-5,800,5/1/2024\n").flights
    assert flight.date_time is None
    assert flight.extra["Date"] == "5/1/2024"


@pytest.mark.parametrize("written", ["13/7/2024 9:30", "7/13/2024 09:30", "13.7.2024 9:30:00"])
def test_the_time_of_a_date_may_have_one_or_two_digits_for_the_hour(written: str) -> None:
    got = flight("Date,Motor,Altitude (ft)", f"{written},F24-4W,923")
    assert got.date_time == datetime(2024, 7, 13, 9, 30)


@pytest.mark.parametrize(
    ("header", "row", "field", "si"),
    [
        ("Engine,Max Alt (ft)", "C6-5,812", "apogee", 247.4976),
        ("Motor,Apogee AGL [ft]", "C6-5,812", "apogee", 247.4976),
        ("Motor,Actual altitude (ft)", "C6-5,812", "apogee", 247.4976),
        ("Motor,Simulated apogee (m),Measured apogee (m)", "C6-5,250,240", "apogee", 240),
        ("Motor,Max. Vel (mph)", "C6-5,100", "top_speed", 44.704),
        ("Motor,Alt (ft),Max G", "C6-5,812,12", "peak_accel", 117.6798),
        ("Motor;Gipfelhöhe (m);Windgeschwindigkeit (km/h)", "C6-5;240;36", "wind", 10),
        ("Rakete;Motor;Höhe (m)", "Alpha;C6-5;240,5", "apogee", 240.5),
    ],
)
def test_abbreviations_and_words_without_meaning_do_not_hide_a_column(
    header: str, row: str, field: str, si: float
) -> None:
    assert flight(header, row).number(field) == pytest.approx(si)


@pytest.mark.parametrize("header", ["Lift-off mass (g)", "Liftoff weight (g)", "Loaded Weight (g)", "mass_on_pad_g"])
def test_a_lift_off_mass_is_found_however_it_is_spelled(header: str) -> None:
    assert 0.03 < (flight(f"Motor,{header},Apogee (ft)", "C6-5,60.5,812").dry_mass or 0) < 0.04


@pytest.mark.parametrize("brackets", ["{}", "({})", "[{}]"])
def test_a_row_of_units_below_the_header_gives_them(brackets: str) -> None:
    ft, mph, g = (brackets.format(unit) for unit in ("ft", "mph", "g"))
    got = imported(
        f"Club launch\n\nDate,Motor,Mass w/o motor,Apogee,Max speed\n,,{g},{ft},{mph}\n2023-06-01,C6-5,34,812,201\n"
    )
    assert not got.rejected
    (only,) = got.flights
    assert (only.apogee, only.top_speed, only.dry_mass) == pytest.approx((247.4976, 89.855, 0.034), rel=1e-4)


def test_a_row_of_totals_is_not_a_flight() -> None:
    got = imported("Date,Motor,Apogee (ft)\n2023-06-01,C6-5,812\n2023-06-02,C6-5,790\n\nAverage:,,801\n")
    assert [one.apogee for one in got.flights] == pytest.approx([247.4976, 240.792])
    assert not got.rejected
    assert "sums up the others" in got.notes[0]
    assert flight("Rocket,Motor,Apogee (ft)", "Max,C6-5,812").rocket == "Max"


@pytest.mark.parametrize(
    ("cells", "dates"),
    [
        (("13/6/2023", "5/7/2023"), ("2023-06-13", "2023-07-05")),
        (("6/13/2023", "5/7/2023"), ("2023-06-13", "2023-05-07")),
        (("6/13/23", "5/7/23 2:05 PM"), ("2023-06-13", "2023-05-07T14:05")),
        (("Jun 13, 2023", "7 May 2023"), ("2023-06-13", "2023-05-07")),
        (("13-Jun-23", "Sunday, May 7, 2023"), ("2023-06-13", "2023-05-07")),
    ],
)
def test_one_unambiguous_date_determines_the_order_of_a_column(cells: tuple[str, ...], dates: tuple[str, ...]) -> None:
    rows = "".join(f'"{cell}",C6-5,{800 + number}\n' for number, cell in enumerate(cells))
    got = imported(f"Launch date,Motor,Apogee (ft)\n{rows}")
    assert [one.date_time for one in got.flights] == [datetime.fromisoformat(text) for text in dates]


def test_a_column_of_dates_in_both_orders_is_kept_as_text() -> None:
    got = imported("Date,Motor,Apogee (ft)\n13/6/2023,C6-5,800\n6/13/2023,C6-5,810\n5/7/2023,C6-5,820\n")
    assert [one.date_time is None for one in got.flights] == [False, False, True]


def test_a_time_of_day_in_its_own_column_completes_the_date() -> None:
    one = flight("Date,Time,Motor,Apogee (ft)", "2024-05-01,2:05 PM,C6-5,812")
    assert one.date_time == datetime(2024, 5, 1, 14, 5)
    assert not one.extra


def test_flights_that_are_numbered_from_one_every_day_are_all_read() -> None:
    got = imported("Date,#,Motor,Apogee (ft)\n2024-05-01,1,C6-5,812\n2024-05-02,1,C6-5,790\n")
    assert not got.rejected
    assert [one.extra["#"] for one in got.flights] == ["1", "1"]


def test_a_plain_row_number_does_not_identify_a_flight_but_a_unique_one_does() -> None:
    one, other = (flight("Date,#,Motor,Apogee (ft)", f"2024-05-0{day},1,C6-5,81{day}") for day in (1, 2))
    assert one.flight_id != other.flight_id
    assert flight("Date,Flight number,Motor,Apogee (ft)", "2024-05-01,17,C6-5,812").flight_id == "17"
    assert flight("Date,Flight,Motor,Apogee (ft)", "2024-05-01,A-3,C6-5,812").flight_id == "A-3"


@pytest.mark.parametrize("column", ["Wind", "Wind (mph)", "wind [mph]"])
def test_a_mapping_of_one_column_does_not_change_the_others(column: str) -> None:
    log = b"Flight #,Model,Motor Used,Alt (ft),Wind (mph)\nA7,Astra,C6-5,812,10\n"
    (plain,) = (item for item in open_log(log, "log.csv", None).found if isinstance(item, Reading))
    choice = read_choice([f"wind={column}"])
    (mapped,) = (item for item in open_log(log, "log.csv", None, [choice]).found if isinstance(item, Reading))
    assert mapped.stated == plain.stated
    assert {"rocket", "motor", "apogee", "wind"} <= plain.stated.keys()


def test_headers_in_other_languages_are_recognized() -> None:
    log = "fusée;moteur;masse au décollage (g);apogée (m);vitesse max (m/s);vent (m/s)\nAstra;C6-5;95;247;70;2\n"
    (reading,) = (item for item in open_log(log.encode(), "vols.csv", None).found if isinstance(item, Reading))
    assert {"rocket", "motor", "apogee", "top_speed", "wind"} <= reading.stated.keys()
    assert reading.liftoff_mass == pytest.approx(0.095)


def test_an_apogee_without_a_unit_is_named_as_the_problem() -> None:
    assert complaint("Motor,Alt", "C6-5,812").startswith("Alt: found '812' without a unit")


@pytest.mark.parametrize("title", ["Spring launch\n", "Spring launch,,,\n\nexported on Sunday\n"])
def test_a_title_above_the_header_is_skipped(title: str) -> None:
    log = f"{title}date,rocket,motor,apogee (ft)\n2024-05-04,Alpha,C6-5,812\n".encode()
    (reading,) = open_log(log, "flights.csv", None).found
    assert isinstance(reading, Reading)
    assert reading.row == title.count("\n") + 2
    assert reading.stated["apogee"] == pytest.approx(812 * 0.3048)


def test_a_standard_name_is_not_read_as_a_shorter_other_name() -> None:
    imported = read(b"flight_id,rocket,coast_to_apogee_s,coast_to_apogee_sd_s\n1,Astra,6.1,0.1\n", "t.csv", any_motor)
    assert (imported.flights[0].coast_to_apogee, imported.flights[0].sd["coast_to_apogee"]) == (6.1, 0.1)


def test_a_row_named_total_is_a_flight_in_fieldkits_table_and_a_sum_in_others() -> None:
    own = b"flight_id,rocket,motor,apogee_m\n1,Astra,F24,200\nTotal,,,200\n"
    others = own.replace(b"flight_id", b"flight")
    assert [len(read(table, "t.csv", any_motor).flights) for table in (own, others)] == [2, 1]


def test_only_texts_short_enough_to_be_a_name_are_looked_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first line of a log may be thousands of numbers, or one cell of them, of which none is a heading."""
    asked: list[str] = []
    monkeypatch.setattr(flight_headings, "usual_name", lambda words: asked.append(words) or words)
    assert {role_of(cell, strict=False).field for cell in ("12.5", "-3", "2025-05-01 10:00", "")} == {""}
    assert asked == []
    assert role_of("apogee_m " * 5000, strict=False).field == ""
    assert len(flight_headings._beginnings("apogee_m_" * 5000)) < 30


def test_a_date_that_cannot_be_read_under_another_name_is_reported() -> None:
    got = imported("Rocket,Motor,Apogee (ft),Date\nSwift,C6-5,900,6/7/2024\nSwift,C6-5,910,5/12/2024\n")
    assert [one.date_time for one in got.flights] == [None, None]
    assert "t.csv, row 2: Date: found '6/7/2024', and 1 more cell, expected a date such as 2026-05-01" in got.notes[0]


def test_a_repeated_header_is_left_out_with_a_note() -> None:
    got = imported("Rocket,Motor,Apogee (ft)\nSwift,C6-5,900\nRocket,Motor,Apogee (ft)\nSwift,C6-5,910\n")
    assert len(got.flights) == 2
    assert not got.rejected
    assert "t.csv, row 3: repeats the header, left out" in got.notes


def test_a_mach_number_does_not_prevent_an_import() -> None:
    got = flight("rocket,motor,apogee_ft,Max speed (Mach)", "Swift,C6-5,900,0.45")
    assert (got.top_speed, got.extra["Max speed (Mach)"]) == (None, "0.45")


@pytest.mark.parametrize("cell", ["?", "unknown", "NULL"])
def test_a_readout_that_is_unknown_is_not_recorded(cell: str) -> None:
    assert flight("rocket,apogee_ft,top_speed_mph", f"Swift,900,{cell}").top_speed is None


@pytest.mark.parametrize(
    ("header", "cell", "si"),
    [
        ("Apogee (meters)", "281", 281.0),
        ("Wind (knots)", "10", 5.14444),
        ("Wind (kts)", "10", 5.14444),
        ("Top speed (feet per second)", "100", 30.48),
        ("dry_mass", "1lb 3oz", 0.538641),
        ("diameter", "2 1/2 in", 0.0635),
        ("Dry mass (pounds)", "0.7", 0.317515),
        ("Pressure (in. Hg)", "29.92", 101320.8),
    ],
)
def test_units_are_read_in_any_spelling(header: str, cell: str, si: float) -> None:
    name = {
        "Apogee": "apogee",
        "Wind": "wind",
        "Top speed": "top_speed",
        "Dry mass": "dry_mass",
        "Pressure": "pressure",
    }
    field = name.get(header.partition(" (")[0], header)
    others = "rocket,motor" if field == "apogee" else "rocket,motor,apogee_m"
    row = "Swift,C6-5" if field == "apogee" else "Swift,C6-5,281"
    assert flight(f"{others},{header}", f"{row},{cell}").number(field) == pytest.approx(si, rel=1e-5)


@pytest.mark.parametrize(
    ("headers", "cells", "kept"),
    [
        ("Time 1,Time 2", "39.1,39.3", {"timer_1_s": "39.1", "timer_2_s": "39.3"}),
        ("Stopwatch 1 (s),Watch 2 (sec)", "39.1,39.3", {"timer_1_s": "39.1", "timer_2_s": "39.3"}),
        ("Timer A,Timer B", "39.1,-", {"timer_1_s": "39.1", "timer_2_s": "-"}),
        ("Egg status,DQ", "1 cracked,no", {"eggs": "1 cracked", "disqualified": "no"}),
        ("Timer 1 (s),Eggs", "39.1,both ok", {"timer_1_s": "39.1", "eggs": "both ok"}),
    ],
)
def test_how_a_contest_flight_was_judged_is_kept_under_one_name(headers: str, cells: str, kept: dict[str, str]) -> None:
    assert flight(f"rocket,motor,apogee_ft,{headers}", f"Swift,F39-6T,801,{cells}").extra == kept


def test_a_judged_cell_under_another_name_that_cannot_be_read_does_not_cost_the_flight() -> None:
    got = imported("rocket,motor,apogee_ft,Time 1\nSwift,F39-6T,801,about 40\nSwift,F39-6T,790,38.1\n")
    assert [one.extra for one in got.flights] == [{"Time 1": "about 40"}, {"timer_1_s": "38.1"}]
    assert got.notes == ("t.csv, row 2: Time 1: found 'about 40', expected seconds such as 38.42: saved as text",)


@pytest.mark.parametrize(
    ("header", "day"),
    [("Temp (F)", datetime(2024, 6, 7)), ("Temp (C)", None)],
)
def test_in_a_table_in_fahrenheit_the_month_comes_first(header: str, day: datetime | None) -> None:
    got = imported(f"Rocket,Motor,Apogee (ft),Date,{header}\nSwift,C6-5,900,6/7/2024,20\n")
    assert got.flights[0].date_time == day
    assert any("--map 'date_time=Date [month/day]' or [day/month]" in note for note in got.notes) == (day is None)


@pytest.mark.parametrize(("order", "month"), [("month/day", 6), ("day/month", 7)])
def test_the_order_of_a_date_can_be_chosen(order: str, month: int) -> None:
    log = b"Rocket,Motor,Apogee (ft),Date\nSwift,C6-5,900,6/7/2024\n"
    found = open_log(log, "log.csv", None, [read_choice([f"date_time=Date [{order}]"])]).found
    (mapped,) = (item for item in found if isinstance(item, Reading))
    assert mapped.stated["date_time"] == datetime(2024, month, 13 - month)


def test_a_time_without_a_unit_is_in_seconds() -> None:
    got = imported("Rocket,Motor,Apogee (ft),Duration,Delay\nSwift,C6-5,900,41.2,5\n")
    assert (got.flights[0].duration, got.flights[0].delay) == (41.2, 5)


def test_an_apogee_without_a_unit_names_the_column_to_map() -> None:
    got = imported("Rocket,Motor,Altitude,Duration\nSwift,C6-5,900,41.2\n")
    assert "--map 'apogee=Altitude [m]'" in got.notes[0]
    assert "--map 'apogee=Alt [m]' for all rows" in complaint("Motor,Alt", "C6-5,812")
