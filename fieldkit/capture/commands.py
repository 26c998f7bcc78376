"""Every command that may be sent to a logger: anything not in this table is never sent.

Loggers accept commands on the same wire that fire their outputs, erase their flights or write their settings, and a
command of one protocol may mean something else to another. The table therefore lists the exact bytes, per protocol, and
contains only read commands; a protocol without an entry can only listen. `SerialLine.send` is the only function that
writes to a port, and it checks this table first.

Sources: RocketFlightLogger (bdureau), AltosLink and AltosEepromDownload (Altus Metrum), Blue Raven USB Interface Guide,
mawd (ukhpr).
"""

import re
from collections.abc import Mapping
from types import MappingProxyType

ALLOWED_COMMANDS: Mapping[str, re.Pattern[bytes]] = MappingProxyType(
    {
        # greeting, settings, number of flights, one of at most 25 flights, fast readout, telemetry
        "altimulti": re.compile(rb"h;|b;|n;|r(?:1?[0-9]|2[0-4]);|[fg];|y[01];"),
        # clear the line, echo off, settings, flash, version, flights, one block of 256 bytes
        "altos": re.compile(rb"~\n|E 0\n|c s\n|f\n|v\n|l\n|e [0-9a-f]{1,6}\n"),
        # clear the line, echo off, version, tune to a frequency in kHz, forward 32-byte packets, stop forwarding
        "teledongle": re.compile(rb"~\n|E 0\n|v\n|c F 4[0-9]{5}\n|m 20\n|m 0\n"),
        # low-rate and high-rate flight data
        "blue_raven": re.compile(rb"download [lh]\r\n"),
        # model, firmware, statistics, last flight
        "mawd": re.compile(rb"[IVSD]"),
    }
)
"""Commands that each protocol may send, as a pattern that must match the whole command."""


class ForbiddenCommand(Exception):
    """Code tried to send a command that is not allowed: a bug; nothing was sent."""


def allowed(protocol: str, command: bytes) -> bool:
    """Whether a protocol may send exactly these bytes."""
    pattern = ALLOWED_COMMANDS.get(protocol)
    return pattern is not None and pattern.fullmatch(command) is not None
