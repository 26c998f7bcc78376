"""Read logs into flights, recordings or plans."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from fieldkit.errors import DamagedLog
from fieldkit.flight import Flight
from fieldkit.flight.log_origin import log_origin
from fieldkit.importing.companion_files import joined
from fieldkit.importing.from_samples import with_figures
from fieldkit.importing.incoming import digest_of
from fieldkit.importing.reading import ColumnChoice, ImportedFile, Parsed, Reading
from fieldkit.importing.recognize import ParsedLog, open_log, shown_damage
from fieldkit.importing.to_flights import CheckMotor, imported_file, plan_of


def read(
    log: bytes,
    source: str,
    check_motor: CheckMotor,
    format: str | None = None,
    choices: Sequence[ColumnChoice] = (),
) -> ImportedFile:
    """The flights of one log; `source` is its name in messages. Raises UnknownFormat or DamagedLog."""
    return read_together([(source, log)], check_motor, format, choices)[0]


def read_together(
    files: Iterable[tuple[str, bytes]],
    check_motor: CheckMotor,
    format: str | None = None,
    choices: Sequence[ColumnChoice] = (),
) -> list[ImportedFile]:
    """The flights of several logs, given as (name, bytes): one ImportedFile per log, in order.

    A list of rockets among them supplies names and masses for the rockets of the others. Several files in one folder
    that a logger wrote for one flight produce one flight, in the first of the files with heights. `choices` map the
    columns of a table, best first. Raises UnknownFormat or DamagedLog for the first file that cannot be used at all,
    before any file is imported.
    """
    return imported_files([open_file(source, log, format, choices) for source, log in files], check_motor)


@dataclass(frozen=True, slots=True, eq=False)
class OpenedFile:
    """A file read by its parser, with its name and the digest of its bytes.

    `measured` is what was found, with figures from its samples; None if files read together may change it.
    """

    source: str
    parsed: ParsedLog
    digest: str
    measured: Sequence[Parsed] | None = None


def open_file(source: str, log: bytes, format: str | None = None, choices: Sequence[ColumnChoice] = ()) -> OpenedFile:
    """Open a log, and measure it if no other file can complete it. Raises UnknownFormat or DamagedLog."""
    parsed, digest = open_log(log, source, format, choices), digest_of(log)
    ((_, name, found),) = joined([(source, parsed.format, parsed.found)], [digest])
    alone = not any(isinstance(item, Reading) and (item.part or _is_numbered(item)) for item in parsed.found)
    return OpenedFile(source, parsed, digest, with_figures(found, name, digest) if alone else None)


def _is_numbered(reading: Reading) -> bool:
    """Whether a logger numbered a flight, so that a file of another kind may belong to the same flight."""
    return bool(reading.serial and log_origin(reading.extra).number)


def read_stored(
    logs: Sequence[bytes], source: str, format: str | None, choices: Sequence[ColumnChoice] = ()
) -> list[Flight]:
    """The flights of one or more files that were imported before; `format` is the format of the first file.

    Raises UnknownFormat or DamagedLog for a file that can no longer be used.
    """
    formats = [format, *(None for _ in logs[1:])]
    read = [open_file(source, log, form, choices) for log, form in zip(logs, formats, strict=True)]
    return [flight for imported in imported_files(read, lambda motor: None) for flight in imported.flights]


def imported_files(read: Sequence[OpenedFile], check_motor: CheckMotor) -> list[ImportedFile]:
    """The contents of opened files, with files of the same flight merged."""
    digests = [one.digest for one in read]
    files = [(one.source, one.parsed.format, one.parsed.found) for one in read]
    measured = [
        (source, name, one.measured if one.measured is not None else with_figures(found, name, one.digest))
        for (source, name, found), one in zip(joined(files, digests), read, strict=True)
    ]
    everything = [item for _, _, found in measured for item in found if isinstance(item, Reading)]
    rockets = {item.rocket_key: item for item in everything if item.describes == "rocket"}
    return [
        replace(imported_file(source, name, found, rockets, check_motor), recognition=one.parsed.recognition)
        for (source, name, found), one in zip(measured, read, strict=True)
    ]


def read_recordings(
    log: bytes,
    source: str,
    format: str | None = None,
    choices: Sequence[ColumnChoice] = (),
    others: Sequence[bytes] = (),
) -> list[Reading]:
    """The readings of a log with samples, both flights and simulations, as recorded.

    `others` are further files that its logger wrote for the same flights. Raises UnknownFormat or DamagedLog, also if
    the log has no samples.
    """
    logs = [open_log(log, source, format, choices), *(open_log(other, source, None, choices) for other in others)]
    opened = [(source, one.format, one.found) for one in logs]
    opened = joined(opened, [""] * len(opened)) if others else opened
    readings = [item for _, _, found in opened for item in found if isinstance(item, Reading) and item.clocks]
    if not readings:
        raise DamagedLog("found no samples, expected a log of heights over time", source=source)
    return readings


def read_plans(table: bytes, source: str, check_motor: CheckMotor) -> list[Flight]:
    """The planned flights of a table, one per row, in order; readouts in it are ignored.

    A plan without a `flight_id` is named after its row, such as `row-2`. Raises DamagedLog for the first bad row,
    because skipping a plan would assign forecasts to the wrong plans, and UnknownFormat as `open_log`.
    """
    plans = []
    for item in open_log(table, source, None).found:
        if isinstance(item, DamagedLog):
            raise shown_damage(item, source)
        if isinstance(item, Reading) and item.describes == "flight":
            try:
                plans.append(plan_of(item, check_motor))
            except DamagedLog as error:
                raise shown_damage(error, source, item.row) from error
    return plans
