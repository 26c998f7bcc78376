"""Readings with samples: their readouts measured, and the name of the flight taken from the bytes."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from fieldkit.reading import Found, Note, Reading


def with_figures(found: Sequence[Found], format: str, digest: str) -> Sequence[Found]:
    """What was found in a log, with the readouts of flights that were recorded measured in their samples."""
    with_samples = [id(item) for item in found if isinstance(item, Reading) and item.clocks]
    if not with_samples:
        return found
    told: list[Found] = []
    for item in found:
        if isinstance(item, Reading) and item.clocks and item.describes == "flight":
            told += _recorded(item, format, digest[:10], with_samples.index(id(item)) + 1, len(with_samples))
        else:
            told.append(item)
    return told


def _recorded(reading: Reading, format: str, digest: str, part: int, parts: int) -> list[Found]:
    """A reading with samples as one whose readouts are measured in them, and what is to be said of that.

    Its flight is named after the bytes of its log, so that another way of measuring does not make it another flight;
    the extra columns say which parser reads the log again, and which of its flights this is.
    """
    from fieldkit.recording import columns, measure

    recorded = measure(reading.clocks, reading.events)
    fields, extra = columns(recorded, reading.stated)
    if not fields.get("flight_id"):
        when = fields.get("date_time")
        start = f"{when:%Y-%m-%d}" if isinstance(when, datetime) else "flight"
        fields["flight_id"] = f"{start}-{digest}" + (f"-{part}" if parts > 1 else "")
    told = {"device": reading.device, "firmware": reading.firmware, "serial": reading.serial, "log_format": format}
    if parts > 1:
        told["log_part"] = str(part)
    known = {name: text for name, text in told.items() if text}
    measured = replace(reading, stated=fields, extra={**reading.extra, **extra, **known})
    return [measured, *(Note(text, reading.row) for text in recorded.notes)]
