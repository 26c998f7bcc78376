"""The user's own files are read, or refused in a line that names the file, whatever they contain."""

import copy
import csv
import datetime
import itertools
import json
import math
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from fieldkit.errors import LONGEST_LINE, BadValue, DamagedLog, FieldkitError, UnknownMotor
from fieldkit.files import LARGEST_TOML, MAX_DOTS, toml_of
from fieldkit.model.hyperprior import read_card
from fieldkit.motors import catalogue
from fieldkit.motors.comparison import compare_tests
from fieldkit.motors.motor import Motor
from fieldkit.motors.own_corrections import FILE_NAME, read_own_corrections
from fieldkit.paths import expanded
from fieldkit.planning.contest import season
from fieldkit.planning.delay import drill_of
from fieldkit.planning.kits import read_kits
from fieldkit.planning.limits import limits
from fieldkit.planning.rules import rule_sets

CHECK_SHAPES = False
DATA = Path(__file__).parents[1] / "fieldkit" / "data"
pytestmark = pytest.mark.fast

TEXTS = {
    "nested values": "K = " + "[" * 50_000,
    "a key of many parts": "K." * 30_000 + "a = 1",
    "an integer of 6,000 digits": "[K]\nvalue = " + "9" * 6000,
    "an integer beyond floats": "[K]\nvalue = " + "9" * 4000 + "\ndiameter_mm = " + "9" * 4000,
    "a list of numbers": "K = [1]",
    "a list of tables": "[[K]]\nvalue = 1",
    "a date": "[K]\nvalue = 0001-01-01\ndiameter_mm = 0001-01-01",
    "no number": "[K]\nvalue = nan\ndiameter_mm = nan",
    "no text": "\x00",
    "more than its limit": "# " + "x" * LARGEST_TOML,
}


def a_motor() -> Motor:
    return catalogue().resolve("Aerotech H283ST-15A").motor


READERS: dict[str, Callable[[Path], object]] = {
    "kits.toml": read_kits,
    "limits.toml": limits,
    "drills.toml": lambda file: drill_of(a_motor(), file),
    "2027.toml": lambda file: season(2027, file.parent),
    "K.toml": lambda file: rule_sets(file.parent),
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
@pytest.mark.parametrize("name", READERS)
def test_a_hostile_file_is_refused_in_one_line(tmp_path: Path, name: str, text: str) -> None:
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(BadValue, match=name) as refused:
        READERS[name](file)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"a":' * 100_000, '{"noise": ' + "9" * 6000 + "}"], ids=["lists", "tables", "digits"]
)
def test_a_hostile_card_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(FieldkitError, match=r"card\.json"):
        read_card(text, "card.json")


def test_numbers_of_ordinary_files_are_read() -> None:
    assert toml_of(f"a = {2**63 - 1}\nb = inf\nc = '{'.' * MAX_DOTS}'")["a"] == 2**63 - 1


def test_a_cell_beyond_the_limit_of_tables_is_refused(tmp_path: Path) -> None:
    before = csv.field_size_limit(131_072)
    try:
        (tmp_path / FILE_NAME).write_text("maker,designation,field,value\n" + "x" * 200_000)
        rows, (error,) = read_own_corrections(tmp_path)
        assert not rows
        assert FILE_NAME in str(error)
        with pytest.raises(BadValue, match=r"tests\.csv"):
            compare_tests(catalogue(), b"manufacturer,designation\n" + b"x" * 200_000, "tests.csv")
    finally:
        csv.field_size_limit(before)


@pytest.mark.parametrize(
    "text",
    ["1" + " " * 80_000 + "x", "9" * 80_000, "F24" + "," * 80_000 + "x", "1/" * 40_000],
    ids=["spaces", "digits", "commas", "stages"],
)
def test_an_overlong_name_is_quickly_found_not_to_be_a_motor(text: str) -> None:
    start = time.process_time()
    with pytest.raises(UnknownMotor) as refused:
        catalogue().resolve_several(text)
    assert time.process_time() - start < 1
    assert len(str(refused.value)) < 2 * LONGEST_LINE


def test_a_message_quotes_at_most_a_part_of_a_long_text() -> None:
    error = DamagedLog("found " + "x" * 1_000_000 + ", expected a number", row=3, source="a.eng")
    assert str(error).startswith("a.eng, row 3: found xxx")
    assert str(error).endswith("xxx, expected a number")
    assert len(str(error)) < 2 * LONGEST_LINE


def test_a_limit_that_is_not_a_number_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "limits.toml"
    for value in ("nan", "inf", "true"):
        file.write_text(f"[{next(iter(limits()))}]\nvalue = {value}\n")
        with pytest.raises(BadValue, match="expected value = a number"):
            limits(file)


SHIPPED = {
    "drills.toml": DATA / "drills.toml",
    "2027.toml": DATA / "seasons" / "2027.toml",
    **{name: DATA / "rules" / name for name in ("car.toml", "faa.toml", "nar_high_power.toml")},
}
READ = {"drills.toml": "AeroTech"}
"""The table that is read for the motor of these tests, if a file has several."""
WRONG_NUMBERS = (math.nan, -1, 1e300, True, "x", [], {})
WRONG_VALUES = ("", "\x1b[31m", [[]], {"a": 1}, [1, "a"], datetime.date(1, 1, 1), [{}], 2**62, math.inf)
Leaf = tuple[str | int, ...]
folder_names = itertools.count()


def shipped(name: str) -> dict[str, Any]:
    """The tables of a shipped file, with the first few of its rules."""
    tables = tomllib.loads(SHIPPED[name].read_text(encoding="utf-8"))
    return tables | ({"rule": tables["rule"][:4]} if "rule" in tables else {})


def leaves(tree: Any, path: Leaf = ()) -> Iterator[tuple[Leaf, Any]]:
    """Every value of a TOML file with its path."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
        yield (*path, key), value
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))


def with_value(tree: Any, path: Leaf, value: Any) -> dict[str, Any]:
    """The tables of a TOML file with one value replaced."""
    changed: dict[str, Any] = copy.deepcopy(tree)
    *above, last = path
    inside: Any = changed
    for key in above:
        inside = inside[key]
    inside[last] = value
    return changed


def as_toml(value: Any) -> str:
    """A value in TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {as_toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(as_toml, value))}]"
    return value.isoformat() if isinstance(value, datetime.date) else json.dumps(value).replace("NaN", "nan")


def reads(name: str, tables: dict[str, Any], folder: Path) -> str:
    """The message with which a file of these tables is refused, empty if it is read."""
    file = folder / f"{next(folder_names)}" / name
    file.parent.mkdir()
    text = "\n".join(f"{json.dumps(key)} = {as_toml(value)}" for key, value in tables.items())
    file.write_text(text.replace("Infinity", "inf"), encoding="utf-8")
    try:
        READERS[name if name in READERS else "K.toml"](file)
    except BadValue as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", SHIPPED)
def test_a_number_that_no_calculation_can_use_is_refused_by_its_file_and_name(name: str, tmp_path: Path) -> None:
    tables = shipped(name)
    numbers = [
        path
        for path, value in leaves(tables)
        if isinstance(value, int | float) and not isinstance(value, bool) and READ.get(name, path[0]) == path[0]
    ]
    assert reads(name, tables, tmp_path) == ""
    for path in numbers:
        for value in WRONG_NUMBERS:
            message = reads(name, with_value(tables, path, value), tmp_path)
            assert message.startswith(f"{name}: found "), (path, value)
            assert "\n" not in message


@pytest.mark.parametrize("name", SHIPPED)
def test_a_file_with_any_value_anywhere_is_read_or_refused(name: str, tmp_path: Path) -> None:
    tables = shipped(name)
    for path, _ in leaves(tables):
        for value in WRONG_VALUES:
            assert "\n" not in reads(name, with_value(tables, path, value), tmp_path)


def test_a_file_saved_by_a_windows_editor_is_read(tmp_path: Path) -> None:
    """With the byte order mark that Notepad writes before UTF-8."""
    (tmp_path / "kits.toml").write_text("[Bertha]\ndry_mass_g = 80\n", encoding="utf-8-sig")
    assert read_kits(tmp_path / "kits.toml")["bertha"].dry_mass == pytest.approx(0.080)


def test_a_typed_path_with_a_nul_is_of_no_file() -> None:
    """The system raises ValueError for one, which no page of the app expects."""
    assert not expanded("a\0b.csv").exists()
