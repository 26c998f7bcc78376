"""Loggers on a serial port: `capture` and `resume` report progress as events, `logs_in` returns what parsers read.

Bytes are saved to disk before they are decoded, and only commands in the table of `commands.py` are ever sent.
"""

from fieldkit.capture.captured import Captured, Log, captures, is_capture, read_capture, unfinished
from fieldkit.capture.events import (
    Back,
    CaptureEvent,
    Ended,
    FlightsListed,
    Instruction,
    Lost,
    PortOpened,
    Progress,
    Recognised,
    Sample,
    Stored,
)
from fieldkit.capture.port import Port, ports
from fieldkit.capture.protocol import CaptureOptions, Protocol, known_device, known_devices, logs_in
from fieldkit.capture.session import capture, resume

__all__ = [
    "Back",
    "CaptureEvent",
    "CaptureOptions",
    "Captured",
    "Ended",
    "FlightsListed",
    "Instruction",
    "Log",
    "Lost",
    "Port",
    "PortOpened",
    "Progress",
    "Protocol",
    "Recognised",
    "Sample",
    "Stored",
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
