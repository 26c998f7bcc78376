"""Where the log of a flight comes from: what an import records in further columns, and reads back from them."""

from collections.abc import Mapping
from dataclasses import dataclass

FORMAT, PART, KINDS, OTHER_LOGS = "log_format", "log_part", "log_kinds", "other_logs"
DEVICE, FIRMWARE, SERIAL, NUMBER = "device", "firmware", "serial", "flight"


@dataclass(frozen=True, slots=True)
class LogOrigin:
    """The files of a flight and the device that wrote them; empty where it is not recorded.

    `format` is the parser of the first file and `part` which of its flights this is, counted from 1. `kinds` are the
    kinds of files it was read from, if its logger writes several, and `others` the digests of all files but the first.
    `number` is the logger's own number of the flight.
    """

    format: str = ""
    part: str = ""
    kinds: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    device: str = ""
    firmware: str = ""
    serial: str = ""
    number: str = ""

    def columns(self) -> dict[str, str]:
        """The further columns of a flight that record it."""
        texts = {DEVICE: self.device, FIRMWARE: self.firmware, SERIAL: self.serial, NUMBER: self.number}
        texts |= {FORMAT: self.format, KINDS: " ".join(self.kinds), PART: self.part}
        return {name: text for name, text in (texts | {OTHER_LOGS: " ".join(self.others)}).items() if text}


def log_origin(columns: Mapping[str, str]) -> LogOrigin:
    """The origin that the further columns of a flight record."""
    text = {name: columns.get(name, "") for name in (FORMAT, PART, DEVICE, FIRMWARE, SERIAL, NUMBER)}
    kinds, others = (tuple(columns.get(name, "").split()) for name in (KINDS, OTHER_LOGS))
    return LogOrigin(text[FORMAT], text[PART], kinds, others, text[DEVICE], text[FIRMWARE], text[SERIAL], text[NUMBER])
