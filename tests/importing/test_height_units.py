"""Heights of a logger in another unit than usual, which its pressures prove."""

from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Series
from fieldkit.importing import Note, Reading
from fieldkit.importing.height_units import with_proven_heights
from fieldkit.importing.read import read
from tests.samples import any_motor

pytestmark = pytest.mark.fast
SAMPLE = Path(__file__).parents[2] / "sample_logs" / "aim_xtra__groups_that_end_early.csv"


def test_an_aim_log_in_feet_has_the_apogee_of_the_same_log_in_meters() -> None:
    header, *rows = SAMPLE.read_text().splitlines()
    places = [place for place, name in enumerate(header.split(",")) if name in ("Pressure AGL", "Pressure MSL")]
    lines = [header]
    for row in rows:
        cells = row.split(",")
        for place in places:
            if place < len(cells) and cells[place].strip():
                cells[place] = f"{float(cells[place]) / 0.3048:.3f}"
        lines.append(",".join(cells))
    plain = read(SAMPLE.read_bytes(), "aim.csv", any_motor)
    feet = read("\n".join(lines).encode(), "aim.csv", any_motor)
    assert feet.flights[0].apogee == pytest.approx(plain.flights[0].apogee, abs=0.1)
    assert any("in feet, not in meters" in note for note in feet.notes)
    assert not any("in feet" in note for note in plain.notes)


@pytest.mark.parametrize(
    ("unit", "top", "changed"),
    [(1.0, 200.0, False), (0.3048, 200.0, True), (3.2808, 200.0, True), (3.2808, 20.0, False)],
)
def test_only_a_climb_that_pressures_show_in_another_unit_is_converted(unit: float, top: float, changed: bool) -> None:
    height = np.concatenate([np.zeros(10), np.linspace(0, top, 60), np.linspace(top, 0, 60)])
    pressure = 95_000 * (1 - height / 44_331) ** 5.2559
    series = Series(
        np.arange(height.size) / 20, pressure=pressure, altitude=height * unit, speed=np.full(130, 10 * unit)
    )
    reading, notes = with_proven_heights(Reading(series=series, device="Logger"))
    [found] = reading.clocks
    assert bool(notes) == changed
    assert found.altitude is not None
    assert found.speed is not None
    assert found.altitude.max() == pytest.approx(top if changed else top * unit, rel=1e-3)
    assert found.speed[0] == pytest.approx(10 if changed else 10 * unit, rel=1e-3)
    assert all(isinstance(note, Note) for note in notes)


def test_a_table_whose_columns_the_flyer_chose_is_left_as_it_is() -> None:
    height = np.linspace(0, 200, 100)
    series = Series(np.arange(100) / 20, pressure=95_000 * (1 - height / 44_331) ** 5.2559, altitude=height * 3.28)
    assert with_proven_heights(Reading(series=series)) == (Reading(series=series), [])


def test_heights_that_start_late_are_compared_from_their_first_samples() -> None:
    height = np.concatenate([np.zeros(10), np.full(100, 200.0)])
    altitude = np.where(height > 0, height, np.nan)  # the first one is that of the top
    series = Series(np.arange(110) / 20, pressure=95_000 * (1 - height / 44_331) ** 5.2559, altitude=altitude)
    assert with_proven_heights(Reading(series=series, device="Logger"))[0].clocks[0] is series
