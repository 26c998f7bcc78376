"""Loggers on a serial port: `capture` and `resume` tell what happens as events, `logs_in` gives what parsers read.

Bytes are on the disc before anything looks at them, and nothing but the table in `commands.py` is ever sent.
"""

from fieldkit.capture.captured import Captured, Log, captures, is_capture, read_capture, unfinished
from fieldkit.capture.events import (
    Back,
    Ended,
    Event,
    Listed,
    Lost,
    Opened,
    Progress,
    Recognised,
    Sample,
    Stored,
    Told,
)
from fieldkit.capture.port import Port, ports
from fieldkit.capture.protocol import Protocol, Wishes, known_device, known_devices, logs_in
from fieldkit.capture.session import capture, resume

__all__ = [
    "Back",
    "Captured",
    "Ended",
    "Event",
    "Listed",
    "Log",
    "Lost",
    "Opened",
    "Port",
    "Progress",
    "Protocol",
    "Recognised",
    "Sample",
    "Stored",
    "Told",
    "Wishes",
    "capture",
    "captures",
    "is_capture",
    "known_device",
    "known_devices",
    "logs_in",
    "ports",
    "read_capture",
    "resume",
    "unfinished",
]
