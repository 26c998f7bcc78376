"""The logs that are given, read: into flights, into recordings as they stand, or into plans."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from fieldkit.errors import DamagedLog
from fieldkit.flight import Flight
from fieldkit.importing.companion_files import joined
from fieldkit.importing.from_samples import with_figures
from fieldkit.importing.incoming import digest_of
from fieldkit.importing.reading import ColumnChoice, Intake, Reading
from fieldkit.importing.recognize import ParsedLog, open_log, shown_damage
from fieldkit.importing.to_flights import CheckMotor, intake_of, plan_of


def read(
    log: bytes,
    source: str,
    check_motor: CheckMotor,
    format: str | None = None,
    choices: Sequence[ColumnChoice] = (),
) -> Intake:
    """The flights of one log; `source` is its name in messages. Raises UnknownFormat or DamagedLog."""
    return read_together([(source, log)], check_motor, format, choices)[0]


def read_together(
    files: Iterable[tuple[str, bytes]],
    check_motor: CheckMotor,
    format: str | None = None,
    choices: Sequence[ColumnChoice] = (),
) -> list[Intake]:
    """The flights of several logs, given as (name, bytes), an Intake each, in order.

    A list of rockets among them names and weighs the rockets of the others. Files of one folder that a logger
    wrote of one flight bring one flight, in the first of them that holds heights. `choices` say which columns of a
    table are what, best first. Raises UnknownFormat or DamagedLog for the first file that cannot be used at all,
    before anything is taken from any. The bytes of a file are let go before its flights are measured.
    """
    return _intakes(
        [(source, open_log(log, source, format, choices), digest_of(log)) for source, log in files], check_motor
    )


def read_stored(
    logs: Sequence[bytes], source: str, format: str | None, choices: Sequence[ColumnChoice] = ()
) -> list[Flight]:
    """The flights of files that were taken in before, of one flight or more; `format` reads the first of them.

    Raises UnknownFormat or DamagedLog for a file that cannot be used at all any more.
    """
    formats = [format, *(None for _ in logs[1:])]
    read = [
        (source, open_log(log, source, form, choices), digest_of(log)) for log, form in zip(logs, formats, strict=True)
    ]
    return [flight for intake in _intakes(read, lambda motor: None) for flight in intake.flights]


def _intakes(read: Sequence[tuple[str, ParsedLog, str]], check_motor: CheckMotor) -> list[Intake]:
    """What files bring, each given as its name, what it was opened as and the digest of its bytes."""
    digests = [digest for *_, digest in read]
    files = [(source, opened.format, opened.found) for source, opened, _ in read]
    measured = [
        (source, name, with_figures(found, name, digest))
        for (source, name, found), digest in zip(joined(files, digests), digests, strict=True)
    ]
    everything = [item for _, _, found in measured for item in found if isinstance(item, Reading)]
    rockets = {item.rocket_key: item for item in everything if item.describes == "rocket"}
    return [
        replace(intake_of(source, name, found, rockets, check_motor), recognition=opened.recognition)
        for (source, name, found), (_, opened, _) in zip(measured, read, strict=True)
    ]


def read_recordings(
    log: bytes,
    source: str,
    format: str | None = None,
    choices: Sequence[ColumnChoice] = (),
    others: Sequence[bytes] = (),
) -> list[Reading]:
    """The readings of a log that hold samples, flights and simulations, as they were recorded.

    `others` are further files that its logger wrote of the same flights. Raises UnknownFormat or DamagedLog, also
    where the log has no samples.
    """
    logs = [open_log(log, source, format, choices), *(open_log(other, source, None, choices) for other in others)]
    opened = [(source, one.format, one.found) for one in logs]
    opened = joined(opened, [""] * len(opened)) if others else opened
    readings = [item for _, _, found in opened for item in found if isinstance(item, Reading) and item.clocks]
    if not readings:
        raise DamagedLog("found no samples, expected a log of heights over time", source=source)
    return readings


def read_plans(table: bytes, source: str, check_motor: CheckMotor, format: str | None = None) -> list[Flight]:
    """The planned flights of a table, one a row and in order; readouts in it are left out.

    A plan without a `flight_id` is named after its row, `row-2`. Raises DamagedLog for the first bad
    row, because a forecast that skips a plan would be taken for another's.
    """
    plans = []
    for item in open_log(table, source, format).found:
        if isinstance(item, DamagedLog):
            raise shown_damage(item, source)
        if isinstance(item, Reading) and item.describes == "flight":
            try:
                plans.append(plan_of(item, check_motor))
            except DamagedLog as error:
                raise shown_damage(error, source, item.row) from error
    return plans
