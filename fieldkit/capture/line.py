"""A serial port on which every byte is saved before it is used, and only allowed commands are sent."""

from dataclasses import dataclass
from typing import Any

from fieldkit.capture.commands import ForbiddenCommand, allowed
from fieldkit.capture.tape import Tape
from fieldkit.errors import PortLost, PortTrouble

WAIT = 0.05
"""Longest wait for bytes in one read. [s]"""


@dataclass(frozen=True, slots=True)
class PortSettings:
    """How a port is opened: 8 data bits, no parity, 1 stop bit, and these."""

    baud: int = 9600
    xonxoff: bool = False


@dataclass(slots=True)
class SerialLine:
    """An open port. `protocol` decides what may be sent, and is empty as long as it is only listened to."""

    name: str
    protocol: str
    tape: Tape
    _port: Any

    def send(self, command: bytes) -> None:
        """Send one command: the only place in fieldkit that writes to a port.

        Raises ForbiddenCommand for anything that is not in the table of this protocol, PortLost.
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
        """Undo an XOFF that noise held, which would hold back every command: none is too long for a unit.

        Linux resumes after an XOFF only if it was asked to stop as well.
        """
        if self._port.xonxoff:
            self._port.set_output_flow_control(False)
            self._port.set_output_flow_control(True)

    def hear(self) -> bytes:
        """The bytes that have arrived, after `WAIT` at most and perhaps none; they are already saved. Raises
        PortLost."""
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

    def close(self) -> None:
        """Close the port, also one that has disappeared."""
        try:
            self._port.close()
        except _faults():
            return


def open_line(name: str, protocol: str, settings: PortSettings, tape: Tape) -> SerialLine:
    """A port, opened for this program alone. Raises PortTrouble with the reason if it cannot be."""
    import serial

    try:
        port = serial.Serial(
            name,
            baudrate=settings.baud,
            xonxoff=settings.xonxoff,
            timeout=WAIT,
            write_timeout=5,
            exclusive=True,
        )
    except _faults() as error:
        raise PortTrouble(f"{name}: cannot be opened ({_reason(error)}); {_advice(error)}") from error
    return SerialLine(name, protocol, tape, port)


def _faults() -> tuple[type[Exception], ...]:
    """What pyserial lets out when a port fails: OSError mostly, on Unix the errors of its terminal too."""
    try:
        from termios import error
    except ImportError:  # Windows
        return (OSError, ValueError)
    return (OSError, ValueError, TypeError, error)


def _reason(error: Exception) -> str:
    """The system's own message for an error, in a few words."""
    texts = [str(part) for part in error.args if isinstance(part, str)]
    return (getattr(error, "strerror", None) or (texts[-1] if texts else type(error).__name__)).splitlines()[0][:120]


def _advice(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == 13:
        return "on Linux your account must be in the group that owns the port, often dialout or uucp"
    if number == 2:
        return "`fieldkit capture --list` shows the ports"
    return "is another program using it?"
