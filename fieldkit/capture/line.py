"""A serial port that saves every byte before it is used and sends only allowed commands."""

from dataclasses import dataclass
from typing import Any

from fieldkit.capture.commands import ForbiddenCommand, allowed
from fieldkit.capture.tape import Tape
from fieldkit.errors import PortLost, PortTrouble

WAIT = 0.05
"""Longest wait for bytes in one read. [s]"""


@dataclass(frozen=True, slots=True)
class PortSettings:
    """Port settings in addition to 8 data bits, no parity and 1 stop bit: the rate [baud], and flow control."""

    baud: int = 9600
    xonxoff: bool = False


@dataclass(slots=True)
class SerialLine:
    """An open port. `protocol` determines what may be sent; it is empty while the port is only listened to."""

    name: str
    protocol: str
    settings: PortSettings
    tape: Tape
    _port: Any

    def send(self, command: bytes) -> None:
        """Send one command: the only function in fieldkit that writes to a port.

        Raises ForbiddenCommand for anything not in the table of this protocol, PortLost, and CaptureTrouble if the
        command cannot be recorded.
        """
        if not allowed(self.protocol, command):
            raise ForbiddenCommand(f"{self.protocol or 'a listener'} may not send {command!r}")
        self.tape.note(sent=command.decode("latin-1"))
        try:
            self._go_on()
            self._port.write(command)
        except _faults() as error:
            raise PortLost(f"{self.name}: the port disappeared ({_reason(error)})") from error

    def _go_on(self) -> None:
        """Clear an XOFF caused by noise, which would block every command; no command is so long that it needs flow
        control.

        Linux resumes after an XOFF only if it was asked to stop as well.
        """
        if self._port.xonxoff:
            self._port.set_output_flow_control(False)
            self._port.set_output_flow_control(True)

    def hear(self) -> bytes:
        """The bytes that arrived within `WAIT`, possibly none; they are already saved.

        Raises PortLost, and CaptureTrouble if they cannot be saved.
        """
        try:
            chunk: bytes = self._port.read(1)
            if chunk:
                chunk += self._port.read(self._port.in_waiting)
        except _faults() as error:
            self.tape.tick()
            raise PortLost(f"{self.name}: the port disappeared ({_reason(error)})") from error
        if chunk:
            self.tape.heard(chunk)
        else:
            self.tape.tick()
        return chunk

    def retune(self, settings: PortSettings) -> None:
        """Change the settings of the port. Raises PortLost."""
        try:
            self._port.baudrate = settings.baud
            self._port.xonxoff = settings.xonxoff
        except _faults() as error:
            raise PortLost(f"{self.name}: the port disappeared ({_reason(error)})") from error
        self.settings = settings

    def close(self) -> None:
        """Close the port, even if it has disappeared."""
        try:
            self._port.close()
        except _faults():
            return


def open_line(name: str, protocol: str, settings: PortSettings, tape: Tape) -> SerialLine:
    """Open a port for exclusive use. Raises PortTrouble with the reason if that fails."""
    import serial  # takes 4 ms to import

    try:
        port = serial.Serial(
            name, baudrate=settings.baud, xonxoff=settings.xonxoff, timeout=WAIT, write_timeout=5, exclusive=True
        )
    except _faults() as error:
        raise PortTrouble(f"{name}: cannot be opened ({_reason(error)}); {_advice(error)}") from error
    return SerialLine(name, protocol, settings, tape, port)


def _faults() -> tuple[type[Exception], ...]:
    """Exceptions that pyserial raises when a port fails: mostly OSError, on Unix also termios errors, and OverflowError
    for a baud rate that no port has."""
    try:
        from termios import error
    except ImportError:  # Windows
        return (OSError, ValueError, OverflowError)
    return (OSError, ValueError, OverflowError, TypeError, error)


def _reason(error: Exception) -> str:
    """The system's message for an error, shortened."""
    texts = [str(part) for part in error.args if isinstance(part, str)]
    return (getattr(error, "strerror", None) or (texts[-1] if texts else type(error).__name__)).splitlines()[0][:120]


def _advice(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == 13:
        return "on Linux your account must be in the group that owns the port, often dialout or uucp"
    if number == 2:
        return "`fieldkit capture --list` shows the ports"
    return "is another program using it?"
