"""RocketLaunchJournal: a flyer's ledger of AltimeterTwo readouts, typed by hand into a table.

It has two files. The launches file has one row per flight, in feet, miles per hour, seconds and g, with numbers without
their leading zero (`.800`, `-.100`) and an empty cell for "none seen". The rockets file has one row per rocket: number,
name and weight in grams, presumably without the motor. Without the rockets file, a launch identifies its rocket only by
number. The motors of one flight are separated by commas (`4 C6-3, D12-3`), its stages by a question mark or the byte
0xBD between spaces; 0xBD next to a name is the half in `½A3-2`. The note is the last field and is not quoted, so it may
contain commas.

`DelayNote` is not a delay but a grade of how well the delay fit: flights with a grade of 5 ejected near apogee and
those with 2 well after it, whatever their motor's delay. It is stored as an unknown column and not used.

Format: jdsmith39/RocketLaunchJournal, source/RocketLaunchJournal.DataSeed/SeedData.
"""

import re
from collections.abc import Mapping
from datetime import datetime

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.plausibility import identity
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.header import SEPARATORS
from fieldkit.importing.tables.text import decode, decode_whole, first_row, rows, shown
from fieldkit.quantities import counted

COLUMNS = {
    "Altitude": ("apogee", "ft"),
    "TopSpeed": ("top_speed", "mph"),
    "BurnTime": ("burn_time", "s"),
    "PeakAcceleration": ("peak_accel", "g"),
    "AverageAcceleration": ("avg_accel", "g"),
    "CoastToApogeeTime": ("coast_to_apogee", "s"),
    "ApogeeToEjectionTime": ("apogee_to_eject", "s"),
    "EjectionAltitude": ("eject_altitude", "ft"),
    "DescentSpeed": ("descent_speed", "mph"),
    "Duration": ("duration", "s"),
}
"""The ten readouts by their names in the journal: field of `Flight`, unit."""
LAUNCH = ("LaunchID", "RocketID", "LaunchNumber", "Date", "Motors", "DelayNote", *COLUMNS, "Note")
ROCKET = ("RocketID", "Name", "Weight")
"""Columns of the launches file, and of the rockets file."""
COPIED_FIELDS = ("LaunchNumber", "DelayNote")
"""Columns that are stored as unknown ones."""
SPELLED_COLUMNS = {name.lower(): name for name in (*LAUNCH, *ROCKET)}
"""The names of the columns by their lower-case spelling, because programs that edit a table may change the case."""
STAGE_MARK = re.compile(r"(?<=\s)[\xbd?](?=\s)")
DEVICE = "AltimeterTwo"


def recognises(head: bytes) -> bool:
    return _header(decode(head)) is not None


def _header(text: str) -> tuple[int, list[str], str] | None:
    """Row number, column names and separator of the header; None if it is not a journal."""
    rows = ((*first_row(text, separator), separator) for separator in SEPARATORS)
    return next((one for one in rows if _kind(one[1])), None)


def _kind(header: list[str]) -> str | None:
    """Which of the two files has this header, if any."""
    names = set(_named(header))
    if names >= set(LAUNCH):
        return "launches"
    return "rockets" if names >= set(ROCKET) else None


def _named(header: list[str]) -> list[str]:
    """The names of a header, those of the journal in its own spelling."""
    return [SPELLED_COLUMNS.get(name.lower(), name) for name in map(str.strip, header) if name]


def read(log: bytes) -> list[Parsed]:
    text = decode_whole(log)
    head = _header(text)
    if head is None:
        raise DamagedLog(f"found no header of the journal, expected {','.join(LAUNCH)}", row=1)
    header_row, header, separator = head
    kind = _kind(header)
    names = _named(header)
    found: list[Parsed] = []
    unmeasured = 0
    for row, cells in rows(text, separator):
        if row <= header_row or (not isinstance(cells, DamagedLog) and not any(map(str.strip, cells))):
            continue
        try:
            record = _record(row, cells, names)
            if kind == "rockets":
                found.append(_rocket(row, record))
            elif any(record[name] for name in COLUMNS):
                found.append(_launch(row, record))
            else:
                unmeasured += 1
        except DamagedLog as error:
            found.append(error)
    if unmeasured:
        found.append(Note(f"launches without a readout are left out: {unmeasured}"))
    return found


def _record(row: int, cells: list[str] | DamagedLog, names: list[str]) -> dict[str, str]:
    """A row as a mapping of name to text. Raises DamagedLog if it does not have a cell for every name."""
    if isinstance(cells, DamagedLog):
        raise cells
    while len(cells) > len(names) and not cells[-1].strip():
        cells = cells[:-1]
    if names[-1] == "Note" and len(cells) > len(names):
        cells = [*cells[: len(names) - 1], ",".join(cells[len(names) - 1 :])]
    if len(cells) != len(names):
        raise DamagedLog(f"found {counted(len(cells), 'cell')}, expected {len(names)}", row=row)
    return dict(zip(names, (cell.strip() for cell in cells), strict=True))


def _rocket(row: int, record: Mapping[str, str]) -> Reading:
    if not record["RocketID"] or not record["Name"]:
        raise DamagedLog("found nothing, expected the rocket's number and name", row=row, column="RocketID")
    stated: dict[str, object] = {"rocket": record["Name"]}
    if record["Weight"]:
        stated["dry_mass"] = _number(row, record, "Weight", "mass", "g")
    columns = {"dry_mass": "Weight", "rocket": "Name"}
    return Reading(stated, columns=columns, row=row, describes="rocket", rocket_key=record["RocketID"])


def _launch(row: int, record: Mapping[str, str]) -> Reading:
    if not record["RocketID"]:
        raise DamagedLog("found nothing, expected the rocket's number", row=row, column="RocketID")
    readouts = {
        field: _number(row, record, name, BY_NAME[field].quantity, unit)
        for name, (field, unit) in COLUMNS.items()
        if record[name]
    }
    stated: dict[str, object] = {
        "flight_id": record["LaunchID"],
        "date_time": _date(row, record["Date"]),
        "motor": " / ".join(map(str.strip, STAGE_MARK.split(record["Motors"]))),
        "tags": tuple(_tags(record["Motors"], Flight().with_changes(**readouts))),
        "notes": record["Note"],
        **readouts,
    }
    columns = {field: name for name, (field, _) in COLUMNS.items()} | {
        "motor": "Motors",
        "flight_id": "LaunchID",
    }
    extra = {name: record[name] for name in COPIED_FIELDS if record[name]}
    return Reading(stated, extra, columns, row, rocket_key=record["RocketID"], device=DEVICE)


def _number(row: int, record: Mapping[str, str], name: str, quantity: str, unit: str) -> float:
    cell = record[name]
    if not re.fullmatch(r"[+-]?(\d{1,9}(\.\d{0,9})?|\.\d{1,9})", cell):
        raise DamagedLog(f"found {shown(cell)}, expected a number in {unit}", row=row, column=name)
    try:
        return units.parse(cell, quantity, unit)
    except BadValue as error:
        raise DamagedLog(str(error), row=row, column=name) from error


def _date(row: int, cell: str) -> datetime | None:
    try:
        return datetime.fromisoformat(cell).replace(tzinfo=None) if cell else None
    except ValueError:
        found = f"found {shown(cell)}, expected a date such as 2015-07-04"
        raise DamagedLog(found, row=row, column="Date") from None


def _tags(motors: str, readouts: Flight) -> list[str]:
    """Reasons to exclude a flight from the fit: several motors, or figures shifted by a column.

    A row is considered shifted if the average acceleration is above the peak, or if the top speed differs by more than
    a factor of two from acceleration times burn time. An ordinary typing error has a smaller effect.
    """
    stages = STAGE_MARK.split(motors)
    several = any("," in stage or re.match(r"\s*\d+\s+\S", stage) for stage in stages)
    tags = ["staged"] * (len(stages) > 1) + ["cluster"] * several
    ratio = identity(readouts)
    average, peak = readouts.avg_accel, readouts.peak_accel
    above = average is not None and peak is not None and average > peak
    return tags + ["altimeter_fault"] * (above or (ratio is not None and not 0.5 <= ratio <= 2))


PARSER = Parser(
    "RocketLaunchJournal with AltimeterTwo readouts (CSV)",
    recognises,
    read,
    signs=("RocketID", "LaunchID|NumberOfLaunches", "Motors|Weight", "PeakAcceleration|Name"),
)
