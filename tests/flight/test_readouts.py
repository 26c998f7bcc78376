"""Readouts keep their standard deviation and source from a table or a log through the ledger to the fit."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit import units
from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, READOUTS, SOURCES, Flight, Readout
from fieldkit.flight.readout import read_sd
from fieldkit.importing.manual_entry import read_changes
from fieldkit.importing.read import read
from fieldkit.ledger import Ledger
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, observe, own_sd, reading_sd
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.physics.setups import recorded
from fieldkit.presentation.export import csv_table, document
from fieldkit.services.manual_entry import enter
from fieldkit.shapes import Array
from tests.effort import examples
from tests.presentation.test_export import as_json, flights
from tests.samples import SAMPLES, any_motor

pytestmark = pytest.mark.fast

LOG = next(sample for sample in SAMPLES if sample.name == "perfectflite__drogue_and_main.pf2")
SHORT = next(sample for sample in SAMPLES if sample.name == "altos_csv__with_satellites.csv")
FLIGHT = Flight(
    "1", "Astra", motor="F24-4W", apogee=281.3, coast_to_apogee=5.2, sd={"apogee": 0.5, "coast_to_apogee": 0.1}
)


@st.composite
def known(draw: st.DrawFn) -> Flight:
    """A flight with standard deviations and sources for some of its readouts."""
    flight = draw(flights)
    names = st.sampled_from(sorted(flight.readouts()))
    sd = draw(st.dictionaries(names, st.floats(1e-6, 1e6)))
    return flight.with_changes(sd=sd, source=draw(st.dictionaries(names, st.sampled_from(sorted(SOURCES)))))


@pytest.mark.parametrize("write", [csv_table, as_json])
def test_a_table_survives_the_ledger_and_an_export_unchanged(
    write: Callable[[list[Flight]], str], tmp_path: Path
) -> None:
    @examples(40)
    @given(known())
    def law(flight: Flight) -> None:
        table = write([flight])
        came = read(table.encode("utf-8"), "table", any_motor)
        assert came.rejected == ()
        ledger.remove(*ledger.ids(ledger.flights()))
        ledger.add(came.flights)
        (held,) = ledger.flights()
        assert ledger.add(came.flights).duplicates == 1
        ledger.undo()
        ledger.redo()
        assert ledger.flights() == [held]
        assert (held.sd.keys(), held.source) == (flight.sd.keys(), flight.source)
        assert write([held]) == table

    with Ledger.open(tmp_path / "ledger.db") as ledger:
        law()


@pytest.mark.parametrize(
    ("header", "cell", "sd"),
    [
        ("apogee_sd_m", "0.5", 0.5),
        ("Apogee SD (ft)", "3", 3 * units.FOOT),
        ("apogee_sd", "3 ft", 3 * units.FOOT),
        ("apogee_sd_m", "", None),
        ("apogee_sd_m", "n/a", None),
    ],
)
def test_a_standard_deviation_is_read_in_any_unit(header: str, cell: str, sd: float | None) -> None:
    table = f"flight_id,rocket,apogee_m,{header},apogee_source\n1,Astra,281.3,{cell},GPS\n"
    (flight,) = read(table.encode(), "t.csv", any_motor).flights
    assert flight.readout("apogee") == Readout(281.3, sd, "gps")
    assert flight.readout("top_speed") is None
    assert flight.extra == {}


@pytest.mark.parametrize("column", READOUTS, ids=lambda column: column.name)
def test_a_standard_deviation_scales_with_its_unit_and_is_not_offset(column: object) -> None:
    for name, unit in units.UNITS[BY_NAME[column.name].quantity].items():  # type: ignore[attr-defined]
        assert read_sd(column.name, "2", name) == 2 * unit.factor  # type: ignore[attr-defined]
    assert units.parse_difference("9", "temperature", "f") == pytest.approx(5)


@pytest.mark.parametrize(
    ("header", "cell", "found"),
    [
        ("apogee_sd_m", "-1", "found '-1', expected a standard deviation above 0 m"),
        ("apogee_sd_ft", "0", "found '0', expected a standard deviation above 0 ft"),
        ("apogee_sd_m", "nan", "found 'nan', expected a number"),
        ("apogee_sd_m", "inf", "found 'inf', expected a number"),
        ("apogee_sd_m", "1e40", "found '1e40', expected a plausible number"),
        ("apogee_sd_m", "1,000", "which may be 1000 or 1.000"),
        ("apogee_sd", "3", "found '3' without a unit"),
        ("apogee_source", "radar", "found 'radar', expected one of typed, baro, accel, gps"),
        ("coast_to_apogee_sd_s", "0.1", "found a value beside an empty coast_to_apogee_s, expected none"),
    ],
)
def test_a_bad_standard_deviation_or_source_rejects_its_row_and_names_the_column(
    header: str, cell: str, found: str
) -> None:
    table = f'flight_id,rocket,apogee_m,{header}\n1,Astra,281.3,"{cell}"\n2,Astra,280,\n'
    imported = read(table.encode(), "t.csv", any_motor)
    (rejected,) = imported.rejected
    assert (rejected.row, rejected.column) == (2, header)
    assert found in rejected.error
    assert [flight.flight_id for flight in imported.flights] == ["2"]


def test_a_standard_deviation_in_a_unit_that_its_readout_cannot_have_is_refused() -> None:
    with pytest.raises(Exception, match="apogee_sd_mph: found the unit 'mph', expected one of m, mm"):
        read(b"flight_id,rocket,apogee_m,apogee_sd_mph\n1,Astra,281.3,3\n", "t.csv", any_motor)


@pytest.mark.parametrize(
    ("member", "found"),
    [
        ('"apogee_sd_m": -1', "expected a standard deviation above 0 m"),
        ('"apogee_sd_m": [1]', "expected a number or null"),
        ('"apogee_source": "radar"', "expected one of typed, baro"),
        ('"duration_sd_s": 1', "beside an empty duration_s"),
    ],
)
def test_a_bad_value_in_json_is_refused(member: str, found: str) -> None:
    text = '{"flights": [{"flight_id": "1", "rocket": "Astra", "apogee_m": 281.3, ' + member + "}]}"
    (rejected,) = read(text.encode(), "x.json", any_motor).rejected
    assert found in rejected.error


def test_standard_deviations_as_text_in_json_of_an_older_fieldkit_are_read() -> None:
    text = '{"flights": [{"flight_id": "1", "apogee_m": 281.3, "apogee_sd_m": "0.66"}]}'
    assert read(text.encode(), "x.json", any_motor).flights[0].sd == {"apogee": 0.66}


def test_a_changed_readout_loses_the_standard_deviation_and_source_of_the_old_one() -> None:
    assert FLIGHT.with_changes(apogee=281.3).sd == FLIGHT.sd
    assert FLIGHT.with_changes(apogee=290.0).sd == {"coast_to_apogee": 0.1}
    assert FLIGHT.with_changes(apogee=None).readout("apogee") is None
    given = FLIGHT.with_changes(apogee=290.0, sd={"apogee": 1.0}, source={"apogee": "gps"})
    assert given.readout("apogee") == Readout(290.0, 1.0, "gps")


def test_a_log_gives_standard_deviations_and_sensors_and_marks_stated_figures() -> None:
    (flight,) = read(LOG.read_bytes(), LOG.name, any_motor).flights
    assert flight.readouts().keys() >= flight.source.keys() >= flight.sd.keys() >= {"apogee", "top_speed"}
    assert flight.source["apogee"] == "baro"
    assert not any(column.sd_header in flight.extra for column in READOUTS)
    (other,) = read(SHORT.read_bytes(), SHORT.name, any_motor).flights
    assert {other.source[name] for name in ("top_speed", "peak_accel")} == {"accel"}


def test_a_typed_readout_is_marked_as_typed_and_has_the_devices_noise(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        flight, _ = enter(ledger, Flight(rocket="Astra", apogee=281.3, duration=40.0))
        assert (dict(flight.sd), flight.source) == ({}, {"apogee": "typed", "duration": "typed"})
        ledger.add([FLIGHT.with_changes(flight_id="2", source={"apogee": "baro"})])
        edited = ledger.edit("2", **read_changes(ledger.flight("2"), {"apogee": "300m"}))
        assert edited.readout("apogee") == Readout(300.0, None, "typed")
        assert edited.sd == {"coast_to_apogee": 0.1}
        ledger.undo()
        assert ledger.flight("2").readout("apogee") == Readout(281.3, 0.5, "baro")
        ledger.redo()
        assert ledger.flight("2") == edited


def test_the_standard_deviation_and_source_of_a_readout_are_edited_like_columns(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([FLIGHT])

        def edit(**changes: str) -> Flight:
            return ledger.edit("1", **read_changes(ledger.flight("1"), changes))

        assert edit(apogee="300m", apogee_sd_ft="10").readout("apogee") == Readout(300.0, 10 * units.FOOT, "typed")
        assert edit(apogee_source="gps").readout("apogee") == Readout(300.0, 10 * units.FOOT, "gps")
        assert edit(apogee_sd_m="").readout("apogee") == Readout(300.0, None, "gps")
        assert edit(apogee="").source == {}
        with pytest.raises(BadValue, match="apogee_m: found a standard deviation or a source without a readout"):
            edit(apogee_sd_m="3")
        with pytest.raises(BadValue, match="apogee_sd_m: found '0', expected a standard deviation above 0"):
            edit(apogee_sd_m="0")
        with pytest.raises(BadValue, match="no column 'apogee_sdm'; did you mean apogee_sd_m"):
            edit(apogee_sdm="3")


@pytest.mark.parametrize(("part", "value"), [("sd", float("nan")), ("sd", -1.0), ("source", "radar")])
def test_a_ledger_stores_no_invalid_standard_deviation_or_source(part: str, value: object, tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        (conflict,) = ledger.add([FLIGHT.with_changes(**{part: {"apogee": value}})]).conflicts
    assert conflict.error.startswith("apogee_s")


def test_json_of_a_flight_has_all_recorded_facts_of_its_readouts() -> None:
    details = document(FLIGHT.with_changes(source={"apogee": "baro"}))
    assert (details["apogee_sd_m"], details["apogee_source"], details["coast_to_apogee_sd_s"]) == (0.5, "baro", 0.1)
    assert "coast_to_apogee_source" not in details
    assert csv_table([FLIGHT]).splitlines()[0].count("apogee_m,apogee_sd_m,top_speed_mps,") == 1


def raw(flights: list[Flight]) -> Array:
    """The readouts that a fit compares, in SI."""
    return np.stack([recorded(flights, name) for name in OBSERVED_READOUTS], axis=-1)


def test_a_fit_uses_the_standard_deviation_of_a_readout_if_there_is_one() -> None:
    bare = FLIGHT.with_changes(sd={})
    own = own_sd([FLIGHT, bare], raw([FLIGHT, bare]))
    apogee, coast, speed = (OBSERVED_READOUTS.index(name) for name in ("apogee", "coast_to_apogee", "top_speed"))
    assert own[0, apogee] == pytest.approx(0.5 / 281.3)
    assert own[0, coast] == pytest.approx(0.1 / 5.2)
    assert np.isnan(own[1]).all()
    assert np.isnan(own[0, speed])
    data = observe(history_of([FLIGHT, bare], [catalogue().resolve("F24-4W")] * 2, used_in_fit=[True, True]))
    assert data.sd[0, apogee] == own[0, apogee]
    assert data.sd[1, apogee] == pytest.approx(reading_sd(np.exp(data.values))[1, apogee])
    late = Flight(apogee=100.0, apogee_to_eject=-1.0, sd={"apogee_to_eject": 0.3})
    assert own_sd([late], raw([late]))[0, ~IS_LOGARITHMIC] == [0.3], (
        "a readout about zero is compared by its difference"
    )


HEIGHTS = (251.0, 246.5, 254.2, 249.1, 250.3, 320.0)


def test_an_imprecise_apogee_moves_a_forecast_less_than_a_precise_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    middles = []
    for sd in ("0.5", "60"):
        rows = [f"{n},Law,A,F24-4W,322,66,{apogee},{sd if n == 5 else ''}" for n, apogee in enumerate(HEIGHTS)]
        table = tmp_path / f"{sd}.csv"
        table.write_text(
            "\n".join(["flight_id,rocket,config,motor,dry_mass_g,diameter_mm,apogee_m,apogee_sd_m", *rows])
        )
        ledger = ["--ledger", str(tmp_path / f"{sd}.db")]
        assert main([*ledger, "import", str(table)]) == 0
        capsys.readouterr()
        assert main([*ledger, "predict", "--rocket", "Law", "--motor", "F24-4W", "--config", "A", "--json"]) == 0
        middles.append(json.loads(capsys.readouterr().out)["predictions"][0]["apogee_m"]["p50"])
    assert middles[0] - middles[1] > 1
