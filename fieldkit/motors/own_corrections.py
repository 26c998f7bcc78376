"""The user's own corrections of motors, and data of single lots: `motor_corrections.csv` in their folder.

Its columns are those of the shipped table (maker, designation, field, was, value, confidence, source), plus two that
may be empty: `lot`, as printed on the motor, and `date`, its date of manufacture. A row with a lot applies only to that
lot, which is given with the motor's name: `F24-4W lot 0412`. Spreadsheets may save it with semicolons or tabs, and
with decimal commas. A row that cannot be used is reported, and does not affect the others.
"""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit import files
from fieldkit.errors import BadValue, FieldkitError
from fieldkit.file_lock import changing
from fieldkit.motors.corrections import CONFIDENCES, QUANTITIES, Correction
from fieldkit.motors.motor import PLUGGED_DELAY, Motor

HEADER = "maker,designation,field,was,value,confidence,source,lot,date\n"
FILE_NAME = "motor_corrections.csv"
NEEDED_COLUMNS = {"maker", "designation", "field", "value"}
"""Columns without which a row means nothing."""
SEPARATORS = (",", ";", "\t")
"""Separators of columns that spreadsheets write."""
OWN_FIELDS = (*QUANTITIES, "delays")
"""Fields that a user can correct."""
LONGEST_DELAY = 100.0
"""A longer delay is a typing error: the longest for sale is about 20 s. [s]"""


@dataclass(frozen=True, slots=True)
class OwnCorrection:
    """One row and its number in the file: the motor and, if it applies only to one lot, that lot and its date of
    manufacture."""

    maker: str
    designation: str
    lot: str
    date: str
    correction: Correction
    number: int

    def text(self) -> str:
        """The correction in a line; the previous value only if its row has one."""
        return self.correction.text(before=bool(self.correction.was))


def correction_file(folder: Path) -> Path:
    """The user's table, which is created with its header if missing. Raises FieldkitError if it cannot be written."""
    file = folder / FILE_NAME
    if not file.exists():
        with changing(file):
            if not file.exists():
                files.replace(file, HEADER.encode())
    return file


def read_own_corrections(folder: Path) -> tuple[list[OwnCorrection], list[FieldkitError]]:
    """The rows of the user's table, and an error for each row that cannot be read; nothing if there is no table."""
    file = folder / FILE_NAME
    if not file.exists():
        return [], []
    try:
        lines = files.read_own(file).removeprefix("\ufeff").splitlines()
        table = csv.DictReader(lines, delimiter=_separator(lines))
        rows = list(enumerate(table, start=2))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        return [], [BadValue(f"{FILE_NAME}: found {error}, expected a table")]
    if missing := NEEDED_COLUMNS - {name.strip() for name in table.fieldnames or () if name}:
        return [], [BadValue(f"{FILE_NAME}: found no column {', '.join(sorted(missing))}, expected {HEADER.strip()}")]
    found: list[OwnCorrection] = []
    errors: list[FieldkitError] = []
    for number, row in rows:
        try:
            found.append(_row(row, number))
        except BadValue as error:
            errors.append(error)
    return found, errors


def _separator(lines: Sequence[str]) -> str:
    """The separator of a table: the one that its heading has most of."""
    heading = lines[0] if lines else ""
    return max(SEPARATORS, key=heading.count)


def _row(row: Mapping[str | None, Any], number: int) -> OwnCorrection:
    text = {key.strip(): value.strip() for key, value in row.items() if key and isinstance(value, str)}
    field, value = text.get("field", ""), text.get("value", "")
    confidence = text.get("confidence") or "sure"
    where = f"{FILE_NAME}, row {number}"
    if field not in OWN_FIELDS:
        raise BadValue(f"{where}, field: found {field[:30]!r}, expected one of {', '.join(OWN_FIELDS)}")
    if confidence not in CONFIDENCES:
        raise BadValue(f"{where}, confidence: found {confidence[:30]!r}, expected one of {', '.join(CONFIDENCES)}")
    if field == "delays":
        _delays(value, where)
    else:
        value = f"{_figure(value, where):.12g}"
    one = Correction(field, text.get("was", ""), value, confidence, text.get("source") or f"your own {FILE_NAME}")
    return OwnCorrection(
        text.get("maker", ""), text.get("designation", ""), text.get("lot", ""), text.get("date", ""), one, number
    )


def _figure(value: str, where: str) -> float:
    try:
        number = float(value.replace(",", "."))
    except ValueError:
        number = float("nan")
    if not 0 < number < 1e6:
        raise BadValue(f"{where}, value: found {value[:20]!r}, expected a number above zero")
    return number


def _delays(value: str, where: str) -> tuple[float, ...]:
    try:
        seconds = tuple(PLUGGED_DELAY if part.strip() == "P" else float(part) for part in value.split(","))
    except ValueError:
        seconds = (float("nan"),)
    if all(0 <= one <= LONGEST_DELAY or one == PLUGGED_DELAY for one in seconds):
        return seconds
    raise BadValue(f"{where}, value: found {value[:20]!r}, expected delays such as 4,6,8 or P")


def corrected(motor: Motor, one: OwnCorrection) -> Motor:
    """The motor with the value of a row, unless it is open, and with the correction added to its own.

    Raises FieldkitError for a mass that the motor cannot have.
    """
    was = one.correction.was or _listed(motor, one.correction.field)
    reported = replace(one.correction, was=was, source=_source(one))
    changed = _with(motor, one) if one.correction.applied else motor
    return replace(changed, corrections=(*motor.corrections, reported))


def _listed(motor: Motor, field: str) -> str:
    """A value of a motor as a table has it, empty if unknown."""
    if field == "delays":
        return ",".join("P" if delay == PLUGGED_DELAY else f"{delay:g}" for delay in motor.delays)
    value = {
        "total_impulse_ns": motor.total_impulse,
        "average_n": motor.certified_average,
        "peak_n": motor.certified_peak,
        "burn_s": motor.burn_time,
        "propellant_g": motor.propellant_mass * 1e3,
        "loaded_g": motor.loaded_mass * 1e3,
        "length_mm": motor.length * 1e3,
    }[field]
    return "" if value is None else f"{value:.4g}"


def _source(one: OwnCorrection) -> str:
    lot = f", lot {one.lot}" if one.lot else ""
    return f"{one.correction.source}{lot}{f' of {one.date}' if one.date else ''}"


def _with(motor: Motor, one: OwnCorrection) -> Motor:
    field, text = one.correction.field, one.correction.value
    if field == "delays":
        return replace(motor, delays=_delays(text, FILE_NAME))
    value = float(text)
    if field == "total_impulse_ns":
        thrust = np.asarray(motor.thrust * (value / motor.total_impulse))
        return replace(motor, total_impulse=value, thrust=thrust)
    if field == "burn_s":
        stretch = value / motor.burn_time
        stretched, thrust = np.asarray(motor.time * stretch), np.asarray(motor.thrust / stretch)
        return replace(motor, time=stretched, thrust=thrust, certified_burn=value, curve="")
    if field == "average_n":
        return replace(motor, certified_average=value)
    if field == "peak_n":
        return replace(motor, certified_peak=value)
    if field == "length_mm":
        return replace(motor, length=value * 1e-3)
    if field == "propellant_g":
        casing = motor.loaded_mass - value * 1e-3
        if casing <= 0:
            raise FieldkitError(
                f"{motor.designation}: found {value:g} g of propellant, more than the whole motor weighs"
            )
        return replace(motor, propellant_mass=value * 1e-3, casing_mass=casing)
    casing = value * 1e-3 - motor.propellant_mass
    if casing <= 0:
        raise FieldkitError(f"{motor.designation}: found {value:g} g loaded, expected more than its propellant")
    return replace(motor, casing_mass=casing)
