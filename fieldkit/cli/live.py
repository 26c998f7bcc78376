"""A running capture: counts and altitude, drawn in a terminal, otherwise printed as lines."""

import sys
import time
from collections import deque
from dataclasses import dataclass, field
from types import TracebackType
from typing import TYPE_CHECKING

from fieldkit.cli.screen import complain, measured, system
from fieldkit.presentation.home_text import sparkline
from fieldkit.quantities import ShownUnits
from fieldkit.safe_text import printable

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.live import Live

    from fieldkit.capture import CaptureEvent, Progress, Sample

STALE_ALTITUDE_AGE = 3.0
"""Age above which an altitude is marked as old. [s]"""
WIDTH = 60
"""Number of latest altitudes drawn. [1]"""


@dataclass(slots=True)
class View:
    """The display of a capture; a context that restores the terminal."""

    device: str = ""
    port: str = ""
    highest: float = float("-inf")
    heights: deque[float] = field(default_factory=lambda: deque(maxlen=WIDTH))
    last: "Sample | None" = None
    received_at: float = 0.0
    """When the last altitude arrived, on the monotonic clock. [s]"""
    _live: "Live | None" = None

    def __enter__(self) -> "View":
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.pause()

    def pause(self) -> None:
        """Release the terminal until the next event."""
        if self._live is not None:
            self._live.stop()

    def show(self, event: "CaptureEvent") -> None:
        """Show one event."""
        from fieldkit import capture
        from fieldkit.presentation.capture_text import event_line

        match event:
            case capture.PortOpened(port, device, _):
                self.device, self.port = device, port
            case capture.Recognised(device):
                self.device = device
            case capture.Back(port):
                self.port = port
            case capture.Progress():
                self._draw(event)
        if line := event_line(event):
            self._say(line)

    def _say(self, text: str) -> None:
        if self._live is None:
            complain(text)
        else:
            self._live.console.print(printable(text), markup=False, highlight=False, soft_wrap=True)

    def _draw(self, progress: "Progress") -> None:
        if progress.sample is not None and progress.sample != self.last:
            self.last, self.received_at = progress.sample, time.monotonic()
            self.highest = max(self.highest, progress.sample.altitude)
            self.heights.append(progress.sample.altitude)
        if self._live is not None:
            if not self._live.is_started:
                self._live.start()
            self._live.update(self._picture(progress), refresh=True)

    def _picture(self, progress: "Progress") -> "RenderableType":
        from rich.text import Text

        from fieldkit.presentation.capture_text import counts

        received = [*counts(progress), *([f"{progress.fraction:.0%}"] if progress.fraction is not None else [])]
        lines = [f"{self.device or 'listening'} on {self.port}   {', '.join(received)}"]
        if progress.sample is not None:
            altitude = measured("apogee", progress.sample.altitude)
            lines.append(f"altitude {altitude}   highest {measured('apogee', self.highest)}")
            lines.append(flight_line(progress.sample, time.monotonic() - self.received_at))
            lines.append(sparkline([*self.heights], WIDTH))
        return Text("\n".join(map(printable, lines)), no_wrap=True, overflow="ellipsis")


def flight_line(sample: "Sample", age: float) -> str:
    """Speed, state and, if it is old, age [s] of a sample."""
    parts = (
        [f"{'+' if sample.speed >= 0 else ''}{ShownUnits(system()).speed(sample.speed)}"]
        if sample.speed is not None
        else []
    )
    parts += [sample.state] if sample.state else []
    parts += [f"received {age:.0f} s ago"] if age > STALE_ALTITUDE_AGE else []
    return "   ".join(parts)
