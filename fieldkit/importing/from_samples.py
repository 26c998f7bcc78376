"""Readings with samples: measure the readouts, and name the flight after its bytes."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from fieldkit.analysis import (
    NO_FLIGHT,
    by_device,
    columns,
    measure,
    rises,
    simulated,
    true_apogee,
    widened_by_contradictions,
)
from fieldkit.analysis.channels import MIN_SAMPLES
from fieldkit.analysis.notes import NO_HEIGHT
from fieldkit.errors import DamagedLog
from fieldkit.flight import MEASURED, READOUTS
from fieldkit.flight.log_origin import LogOrigin
from fieldkit.importing.height_units import with_proven_heights
from fieldkit.importing.jumped_clock import with_even_clock
from fieldkit.importing.reading import MOST_FLIGHTS, Note, Parsed, Reading
from fieldkit.messages import marked, message
from fieldkit.quantities import counted


def with_figures(found: Sequence[Parsed], format: str, digest: str) -> Sequence[Parsed]:
    """What was found in a log, with the readouts of each flight measured from its samples; a DamagedLog in place of the
    flights after the first `MOST_FLIGHTS`."""
    with_samples = [id(item) for item in found if isinstance(item, Reading) and item.clocks]
    results: list[Parsed] = []
    for item in found:
        if isinstance(item, Reading) and item.describes == "simulation":
            results.append(replace(item, recorded=simulated(item.clocks, item.events)))  # displayed but never stored
        elif not isinstance(item, Reading) or item.describes != "flight":
            results.append(item)
        elif item.clocks:
            part = with_samples.index(id(item)) + 1
            if part <= MOST_FLIGHTS:
                results += _recorded(item, format, digest[:10], part, len(with_samples))
            elif part == MOST_FLIGHTS + 1:
                more = f"found more than {MOST_FLIGHTS} flights in a log, read the first ones; split it"
                results.append(DamagedLog(more, row=item.row))
        else:
            results.append(_stated(item, format) if item.part else item)
    return results


def _recorded(reading: Reading, format: str, digest: str, part: int, parts: int) -> list[Parsed]:
    """A reading with samples, its readouts measured from them, and the notes about that; or an error if the samples
    show no flight and the log states no readouts.

    The flight is named after the bytes of its log, so that measuring it differently does not create another flight. The
    extra columns name the parser that reads the log again, and which of its flights this is.
    """
    reading, proven = with_proven_heights(reading)
    reading, jumps = with_even_clock(reading)
    recorded = widened_by_contradictions(measure(reading.clocks, reading.events), reading.stated)
    recorded = replace(recorded, device=by_device(reading.clocks, recorded, reading.events))
    air = [
        float(one) if isinstance(one := reading.stated.get(name), float) else None
        for name in ("temperature", "elevation")
    ]
    recorded = replace(recorded, true_apogee=true_apogee(recorded, reading.clocks, *air))
    if NO_FLIGHT in recorded.notes and not (reading.part or _states_figures(reading)):
        return [DamagedLog(f"found no flight: {NO_FLIGHT}", row=reading.row)]
    samples = max((series.time.size for series in reading.clocks), default=0)
    if NO_HEIGHT in recorded.notes and samples < MIN_SAMPLES and not _states_figures(reading):
        return [DamagedLog(f"found {counted(samples, 'sample')}, expected at least {MIN_SAMPLES}", row=reading.row)]
    if NO_HEIGHT in recorded.notes and not (reading.part or _states_figures(reading) or rises(reading.clocks)):
        return [DamagedLog(f"found no flight: {NO_HEIGHT}, and no thrust in an acceleration", row=reading.row)]
    fields, extra = columns(recorded, reading.stated)
    if not (
        reading.part or _states_figures(reading) or any(fields.get(column.name) is not None for column in MEASURED)
    ):
        why = "; ".join(map(marked, recorded.notes)) or "the samples show none"
        return [DamagedLog(message(f"found a flight without any readout: {why}"), row=reading.row)]
    if not fields.get("flight_id"):
        when = fields.get("date_time")
        start = f"{when:%Y-%m-%d}" if isinstance(when, datetime) else "flight"
        fields["flight_id"] = f"{start}-{digest}" + (f"-{part}" if parts > 1 else "")
    known = _origin(reading, format, str(part) if parts > 1 else "")
    measured = replace(reading, stated=fields, extra={**reading.extra, **extra, **known}, recorded=recorded)
    return [measured, *proven, *jumps, *(Note(text, reading.row) for text in recorded.notes)]


def _states_figures(reading: Reading) -> bool:
    """Whether a log states readouts itself in addition to its samples."""
    return any(isinstance(reading.stated.get(column.name), float) for column in READOUTS)


def _stated(reading: Reading, format: str) -> Reading:
    """A summary of a flight whose samples are in other files; its values are marked as coming from the device."""
    figures = {c.stated_header: c.render(v) for c in READOUTS if isinstance(v := reading.stated.get(c.name), float)}
    source = {c.name: "stated" for c in READOUTS if c.stated_header in figures}
    extra = {**reading.extra, **figures, **_origin(reading, format)}
    return replace(reading, stated={**reading.stated, "source": source}, extra=extra)


def _origin(reading: Reading, format: str, part: str = "") -> dict[str, str]:
    """Extra columns with the device of a flight and the files that it was read from."""
    kinds = tuple(reading.part.split())
    return LogOrigin(
        format, part, kinds, device=reading.device, firmware=reading.firmware, serial=reading.serial
    ).columns()
