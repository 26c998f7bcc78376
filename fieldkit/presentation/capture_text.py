"""A running capture in words: its events, and the amount received so far."""

from fieldkit import capture
from fieldkit.quantities import counted


def event_line(event: capture.CaptureEvent) -> str:
    """The text of an event; empty for one that is drawn instead."""
    match event:
        case capture.PortOpened(port, device, file):
            return f"{device or 'listening'} on {port}; every byte goes to {file}"
        case capture.Recognised(device):
            return f"this is {capture.known_devices()[device].title}"
        case capture.Instruction(text):
            return text
        case capture.FlightsListed(flights, chosen):
            return f"{counted(len(flights), 'flight')} in memory, reading {len(chosen)}"
        case capture.Lost(_, why):
            return f"{why}; everything received is saved, waiting for the unit to return"
        case capture.Back(port):
            return f"reconnected on {port}"
    return ""


def counts(progress: capture.Progress) -> list[str]:
    """The amount received: bytes, samples, and damaged samples if there are any."""
    damaged = [f"{progress.damaged:,} damaged"] if progress.damaged else []
    return [counted(progress.bytes, "byte"), counted(progress.samples, "sample"), *damaged]
