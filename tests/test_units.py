"""Numbers as flyers type them, with and without units."""

from datetime import datetime

import pytest

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.importing.manual_entry import read_answer
from fieldkit.services.manual_entry import typed_number, typed_unit, with_unit

pytestmark = pytest.mark.fast

FOOT, INCH, POUND, OUNCE = 0.3048, 0.0254, 0.45359237, 0.028349523125

TYPED = {
    "length": {
        "923'": 923 * FOOT,
        "923 foot": 923 * FOOT,
        "923 ft AGL": 923 * FOOT,
        "0.5in": 0.5 * INCH,
        '2.6"': 2.6 * INCH,
        "2.6 inches": 2.6 * INCH,
        "1/2in": 0.5 * INCH,
        "½ in": 0.5 * INCH,
        "1 1/2 in": 1.5 * INCH,
        "1-1/2 in": 1.5 * INCH,
        "1½″": 1.5 * INCH,
        "12'6\"": 12.5 * FOOT,
        "12' 6": 12.5 * FOOT,
        "12 ft 6 in": 12.5 * FOOT,
        "12 ft. 6.5 in.": 12 * FOOT + 6.5 * INCH,
        "-1' 6\"": -1.5 * FOOT,
        "3 meters": 3.0,
        "−5 m": -5.0,
        "281,3 m": 281.3,
        "1,250 ft": 1250 * FOOT,
        "12,345 ft": 12345 * FOOT,
        "1,250.5 ft": 1250.5 * FOOT,
        "1.250,5 m": 1250.5,
        "1,234,567 m": 1234567.0,
        "1 250 m": 1250.0,
        "0,330 m": 0.33,
        "1.250 m": 1.25,
        "1e3 m": 1000.0,
    },
    "mass": {
        "12 oz": 12 * OUNCE,
        "12 ounces": 12 * OUNCE,
        "1lb 3oz": POUND + 3 * OUNCE,
        "1 lb, 3.5 oz": POUND + 3.5 * OUNCE,
        "2 pounds": 2 * POUND,
        "330 grams": 0.33,
        "1 kg 250 g": 1.25,
    },
    "temperature": {
        "36 F": 275.37222,
        "36 deg F": 275.37222,
        "36 ° F": 275.37222,
        "36 ºF": 275.37222,
        "-5 degrees C": 268.15,
        "20 Celsius": 293.15,
    },
    "pressure": {
        "29.92inHg": 101320.8,
        "29.92 in. Hg": 101320.8,
        '29.92"': 101320.8,
        "1.013 bar": 101300.0,
        "1,013 mbar": None,
        "760 torr": 101324.7,
    },
    "speed": {
        "5 kts": 2.57222,
        "5 knot": 2.57222,
        "10 kmph": 2.77778,
        "10 ft/sec": 3.048,
        "10 feet per second": 3.048,
        "5 miles per hour": 2.2352,
        "5 m / s": 5.0,
    },
    "acceleration": {"5 Gs": 49.03325, "50 m/s/s": 50.0, "50 ft/s²": 15.24},
    "angle": {"5 degrees": 0.0872665, "5º": 0.0872665},
    "time": {"5 seconds": 5.0, "1 min 5 s": 65.0, "1m 5s": 65.0, "0 min 0 s": 0.0},
}


@pytest.mark.parametrize(("quantity", "text"), [(one, text) for one, texts in TYPED.items() for text in texts])
def test_a_typed_number_is_read_as_flyers_write_it(quantity: str, text: str) -> None:
    expected = TYPED[quantity][text]
    if expected is None:
        with pytest.raises(BadValue, match=r"which may be 1013 or 1\.013"):
            units.parse(text, quantity, "")
    else:
        assert units.parse(text, quantity, "") == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("text", ["1,148 m", "1,148 kg", "12,345"])
def test_a_comma_with_two_meanings_is_not_guessed(text: str) -> None:
    with pytest.raises(BadValue, match="expected an unambiguous number"):
        units.parse(text, "mass" if "kg" in text else "length", "m")


@pytest.mark.parametrize(
    "text",
    ["", "ft", "1/0 in", "1 2 3", "1,2,3 ft", "1 ft 3 oz", "5 gr", "1.2.3", "12'6'7", "1/2/3", "--5", "5 %ft", "4o0"],
)
def test_a_text_that_is_no_number_is_rejected(text: str) -> None:
    with pytest.raises(BadValue, match="found "):
        units.parse(text, "length", "m")


def test_a_comma_is_read_in_the_unit_of_the_question() -> None:
    assert read_answer("apogee", "1,148", "ft") == pytest.approx(1148 * FOOT)
    with pytest.raises(BadValue, match="which may be 1148 or"):
        read_answer("apogee", "1,148", "m")


@pytest.mark.parametrize(
    ("text", "number", "unit"),
    [
        ("923 ft", "923", "ft"),
        ("923", "923", ""),
        ("12'6\"", "12'6\"", "ft"),
        ("1/2", "1/2", ""),
        ("2.5 Inches", "2.5", "Inches"),
    ],
)
def test_the_form_separates_a_number_from_its_unit(text: str, number: str, unit: str) -> None:
    assert (typed_number(text), typed_unit(text)) == (number, unit)
    assert with_unit(text, "m") == (text if unit else f"{text}m")


@pytest.mark.parametrize("text", ["2026-05-13T10:30", "13.5.2026 10:30", "5/13/2026 10:30 AM", "May 13, 2026 10:30"])
def test_a_typed_date_is_read_in_any_unambiguous_spelling(text: str) -> None:
    assert read_answer("date_time", text) == datetime(2026, 5, 13, 10, 30)


def test_a_typed_date_with_two_meanings_is_refused() -> None:
    with pytest.raises(BadValue, match="expected a date such as 2026-05-01"):
        read_answer("date_time", "5/6/2026")
