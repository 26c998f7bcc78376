"""The raw records of Altus Metrum's devices: clock, checksum, sensors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.importing.tables.altos import Coefficients, mp3h6115, ms5607, net_acceleration, seconds, sound
from fieldkit.importing.tables.altos_flash import LAYOUTS, RecordLayout, old_form

pytestmark = pytest.mark.fast

TYPICAL = Coefficients(46372, 43981, 29059, 27842, 31553, 28165)
"""The worked example of the MS5607-02BA03 data sheet."""


def test_pressure_agrees_with_the_example_in_the_data_sheet() -> None:
    pressure, temperature = ms5607(np.array([6465444]), np.array([8077636]), TYPICAL)
    assert pressure == [110002]
    assert temperature == pytest.approx([293.15])


def test_a_cold_sensor_is_compensated_to_second_order() -> None:
    # by hand, from the formulas of the data sheet, in floating point
    for counts in (7_000_000, 5_500_000):
        dt = counts - 31553 * 256
        hundredths = 2000 + dt * 28165 / 2**23
        t2, off2, sens2 = dt**2 / 2**31, 61 * (hundredths - 2000) ** 2 / 16, 2 * (hundredths - 2000) ** 2
        if hundredths < -1500:
            off2 += 15 * (hundredths + 1500) ** 2
            sens2 += 8 * (hundredths + 1500) ** 2
        off = 43981 * 2**17 + 27842 * dt / 64 - off2
        sens = 46372 * 2**16 + 29059 * dt / 128 - sens2
        expected = (6465444 * sens / 2**21 - off) / 2**15
        pressure, temperature = ms5607(np.array([6465444]), np.array([counts]), TYPICAL)
        assert pressure == pytest.approx([expected], abs=5)  # integer arithmetic rounds
        assert temperature == pytest.approx([(hundredths - t2) / 100 + 273.15], abs=0.02)


def test_pressures_exported_from_a_telemetrum_1_are_whole_counts() -> None:
    assert mp3h6115(np.array([21788, 21796, 21784])).round(2).tolist() == [84471.31, 84498.45, 84457.74]


def test_a_clock_of_16_bits_continues_where_it_wraps_and_not_where_it_steps_back() -> None:
    assert seconds(np.array([65500, 65535, 10, 9, 11])).tolist() == pytest.approx(
        [655.0, 655.35, 655.46, 655.45, 655.47]
    )


def test_a_record_is_valid_if_its_bytes_and_the_seed_sum_to_zero() -> None:
    record = [ord("A"), 0, 1, 2, 3, 4, 5, 6]
    record[1] = -(sum(record) + 0x5A) % 256
    assert sound(np.array([record, [*record[:-1], 7]])).tolist() == [True, False]


def test_acceleration_is_zero_on_the_pad_and_one_g_more_at_twice_the_weight() -> None:
    counts = np.array([8158] * 10 + [8158 - 91])
    assert net_acceleration(counts, 8158, 8158, 8340) == pytest.approx([0.0] * 10 + [9.80665])
    assert net_acceleration(counts, 4000, 8158, 8340) is None
    assert net_acceleration(counts, 8158, None, 8340) is None


@given(st.sampled_from(list(LAYOUTS.values())), st.lists(st.from_regex(r"[0-9a-f]{1,4}", fullmatch=True), max_size=40))
def test_words_of_any_length_are_a_record_or_damage(layout: RecordLayout, words: list[str]) -> None:
    size = 2 if layout.size == 8 else 1
    whole = len(words) * size == layout.payload and all(len(word) <= 2 * size for word in words)
    found = old_form(f"D 12ab {' '.join(words)}\n".encode(), 1, "", layout)
    assert len(found.records) == (1 if whole else 0)
    assert bool(found.found) is not whole


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=str)
def test_words_that_run_together_are_damage(layout: RecordLayout) -> None:
    """As long as a good line, with spaces at other places."""
    good = " 12" * layout.payload
    for bad in (" 1 222" + good[6:], good[:-6] + " 222 1", " 1212  " + good[8:]):
        assert old_form(f"D 12ab {bad.strip()}\n".encode(), 1, "", layout).found
