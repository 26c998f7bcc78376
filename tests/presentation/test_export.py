"""Exported tables and JSON import as the same flights."""

import json
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit import units
from fieldkit.flight import COLUMNS, READOUTS, TAGS, Flight
from fieldkit.flight.further_units import COLUMNS as COLUMNS_WITH_UNITS
from fieldkit.flight.further_units import FurtherColumn
from fieldkit.flight.limits import LIMITS
from fieldkit.flight.readout import SOURCES
from fieldkit.importing.read import read
from fieldkit.ledger.rows import differences
from fieldkit.presentation.export import csv_table, document
from fieldkit.quantities import SYSTEMS
from tests.effort import examples
from tests.samples import any_motor

pytestmark = pytest.mark.fast

letters = st.characters(
    codec="utf-8",
    exclude_categories=["Cc", "Zs", "Zl", "Zp"],
    exclude_characters="\N{MINUS SIGN}",  # read as a hyphen, because spreadsheets of some countries write it for one
)
words = st.text(letters, max_size=8)


def number(name: str) -> st.SearchStrategy[float | None]:
    """An SI value that the column may have."""
    column = next(column for column in COLUMNS if column.name == name)
    scale = units.unit(column.quantity, column.unit)
    return st.none() | st.floats(*LIMITS[name]).filter(lambda x: x == 0 or abs(x) >= 1e-9).map(scale.to_si)


def further_columns() -> st.SearchStrategy[dict[str, str]]:
    """Further columns whose unit is known, each in any unit in which a flyer may write it."""
    figures = st.tuples(st.floats(0.01, 50.0), st.integers(0, 99))
    return st.dictionaries(st.sampled_from(COLUMNS_WITH_UNITS), figures, max_size=3).map(
        lambda found: {
            column.header((written := written_units(column))[choice % len(written)]): f"{value:.5g}"
            for column, (value, choice) in found.items()
        }
    )


def written_units(column: FurtherColumn) -> list[str]:
    return [unit for unit in units.UNITS[column.quantity] if unit.isalpha()]


def by_name(flight: Flight) -> tuple[str, str]:
    return flight.rocket, flight.flight_id


flights = st.builds(
    Flight,
    flight_id=words.filter(bool),
    rocket=words,
    config=words,
    site=words,
    notes=words,
    tags=st.lists(st.sampled_from([*TAGS, "mine", "not mine"]), unique=True, max_size=3).map(tuple),
    date_time=st.none() | st.datetimes(),
    extra=st.builds(
        lambda own, known: own | known,
        st.dictionaries(st.sampled_from(["Lot", "wind_direction", "Crew", "paint_g"]), words.filter(bool)),
        further_columns(),
    ),
    **{column.name: number(column.name) for column in COLUMNS},
).filter(lambda flight: bool(flight.readouts()))
sds = st.fixed_dictionaries({}, optional={column.name: st.floats(1e-3, 50.0) for column in READOUTS})
sources = st.fixed_dictionaries({}, optional={column.name: st.sampled_from(list(SOURCES)) for column in READOUTS})
flights = st.builds(
    lambda flight, **beside: flight.with_changes(
        **{
            part: {name: one for name, one in every.items() if name in flight.readouts()}
            for part, every in beside.items()
        }
    ),
    flights,
    sd=sds,
    source=sources,
)


def as_json(flights: list[Flight]) -> str:
    return json.dumps({"flights": [document(flight) for flight in flights]})


@pytest.mark.parametrize(
    "write", [*(partial(csv_table, system=system) for system in SYSTEMS), as_json], ids=[*SYSTEMS, "JSON"]
)
def test_an_export_imports_as_the_same_flights(write: object) -> None:
    @examples(60)
    @given(st.lists(flights, min_size=1, max_size=3, unique_by=by_name))
    def law(flights: list[Flight]) -> None:
        imported = read(write(flights).encode("utf-8"), "export", any_motor)
        assert imported.rejected == ()
        assert [differences(*pair) for pair in zip(flights, imported.flights, strict=True)] == [[]] * len(flights)

    law()


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('{"flights": [{"apogee_m": true}]}', "found 'True', expected a number or null"),
        ('{"flights": [{"apogee_m": NaN}]}', "found 'nan', expected a number or null"),
        ('{"flights": [{"apogee_m": 1' + "0" * 400 + "}]}", "expected a number or null"),
        ('{"flights": [{"rocket": 3}]}', "found '3', expected text"),
        ('{"flights": ["one"]}', "expected a flight in braces"),
        ('{"flights": [{"date_time": "soon"}]}', "found 'soon', expected a date"),
    ],
)
def test_an_invalid_flight_is_rejected_with_its_position(text: str, found: str) -> None:
    (rejected,) = read(text.encode(), "x.json", any_motor).rejected
    assert rejected.row == 1
    assert found in rejected.error


def test_every_readout_is_in_the_document() -> None:
    assert {column.header for column in READOUTS} <= set(document(Flight()))


def test_unusual_line_separators_in_a_text_do_not_break_a_row() -> None:
    flight = Flight(flight_id="a\rb", rocket="c\nd", motor="C6-5", notes="'=e", apogee=100.0)
    assert list(read(csv_table([flight]).encode(), "t.csv", lambda name: None).flights) == [flight]
