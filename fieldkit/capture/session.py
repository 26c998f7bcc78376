"""A capture from start to end, across lost and regained ports, as a stream of events."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path

from fieldkit.capture.captured import Captured, read_capture
from fieldkit.capture.events import Back, CaptureEvent, Ended, Instruction, Lost, PortOpened, Recognised
from fieldkit.capture.line import PortSettings, SerialLine, open_line
from fieldkit.capture.link import Dialogue, Link, Stopped, never
from fieldkit.capture.port import Port, again, ports
from fieldkit.capture.protocol import CaptureOptions, known_device, known_devices
from fieldkit.capture.tape import begin, go_on
from fieldkit.errors import CaptureTrouble, FieldkitError, PortLost, PortTrouble
from fieldkit.quantities import counted

RECOGNITION_BYTES = 16_384
"""Number of received bytes, counted from the end, that are searched to recognize a unit. [byte]"""
RATES = (9600, 19_200, 38_400)
"""Baud rates at which units send unprompted, tried in turn until the data is readable. [baud]"""
PATIENCE = 300.0
"""How long to listen for an unknown unit before giving up. [s]"""

MOST_LOSSES = 5
"""Number of times in a row that a port may be lost again without having sent anything. [1]"""
PAUSE = 0.5
"""Wait before such a port is opened again, for each of these losses. [s]"""
AFTER_A_FAULT = 30.0
"""Silence that ends a capture whose protocol has failed. [s]"""

ListPorts = Callable[[], list[Port]]
"""A function that lists the current ports."""


def capture(
    port: Port,
    device: str | None = None,
    *,
    folder: Path,
    wishes: CaptureOptions = CaptureOptions(),  # noqa: B008  # frozen
    stop: Callable[[], bool] = never,
    look: ListPorts = ports,
) -> Iterator[CaptureEvent]:
    """Capture from a port into a folder; yields events, the last of them `Ended`.

    Every byte is on disk before it is decoded. Without a device, the port's numbers identify it, or else the received
    bytes; nothing is ever sent to a unit identified neither by the user nor by its numbers. Raises PortTrouble if a
    port cannot be opened or a unit does not answer, and what was received is still saved; CaptureTrouble if the capture
    cannot be saved.
    """
    name = _name(device or port.device)
    settings = _settings(name, wishes)
    about = {"device": name, "port": port.name, "vendor": port.vendor, "product": port.product, "serial": port.serial}
    with begin(folder, about | {"settings": asdict(settings)}) as tape:
        try:
            yield from _run(Link(open_line(port.name, name, settings, tape), stop), port, settings, wishes, look)
        except PortTrouble:
            tape.discard_if_empty()
            raise


def resume(
    file: Path,
    port: Port | None = None,
    device: str | None = None,
    *,
    wishes: CaptureOptions = CaptureOptions(),  # noqa: B008  # frozen
    stop: Callable[[], bool] = never,
    look: ListPorts = ports,
) -> Iterator[CaptureEvent]:
    """Resume a capture, on the port where its unit is now; data it already has is not read again.

    Raises CaptureTrouble if there is no such capture, its journal is damaged or its unit is not found, and the errors
    of `capture`.
    """
    captured = read_capture(file)
    numbers = (captured.fact("vendor"), captured.fact("product"))
    vendor, product = (number if isinstance(number, int) else None for number in numbers)
    unit = Port(str(captured.fact("port") or ""), vendor, product, str(captured.fact("serial") or ""))
    if port is None:
        here = look()
        found = again(unit, here)
        if found is None:
            known = ", ".join(one.name for one in here) or "none"
            raise CaptureTrouble(
                f"{file.name}: its unit was on {unit.name} and is no longer there; current ports: {known}"
            )
        port = replace(unit, name=found)
    name = _name(device or captured.device)
    settings = _settings(name, wishes, _baud_of(captured) if name == captured.device else None)
    if captured.began is None:
        raise CaptureTrouble(f"{file.name}: its journal is damaged; import it and start another capture")
    with go_on(captured.file, captured.began) as tape:
        tape.note(
            device=name,
            port=port.name,
            vendor=port.vendor,
            product=port.product,
            serial=port.serial,
            settings=asdict(settings),
            whole=False,
        )
        yield from _run(Link(open_line(port.name, name, settings, tape), stop), port, settings, wishes, look)


def _name(device: str) -> str:
    """The name of a known protocol, empty for none. Raises PortTrouble for an unknown name."""
    if not device:
        return ""
    wanted = known_device(device)
    return next(name for name, one in known_devices().items() if one is wanted)


def _settings(name: str, wishes: CaptureOptions, found: int | None = None) -> PortSettings:
    """Settings of a protocol, or for listening without one, at the rate [baud] that was asked for, or else `found`."""
    settings = known_devices()[name].settings if name else PortSettings(RATES[0])
    baud = wishes.baud or (found if name else None)
    return replace(settings, baud=baud) if baud else settings


def _baud_of(captured: Captured) -> int | None:
    """The rate at which a unit was captured [baud]; None if the journal does not state one."""
    settings = captured.fact("settings")
    baud = settings.get("baud") if isinstance(settings, Mapping) else None
    return baud if isinstance(baud, int) and baud > 0 else None


def _run(
    link: Link, port: Port, settings: PortSettings, wishes: CaptureOptions, look: ListPorts
) -> Iterator[CaptureEvent]:
    """Run a capture on an opened port to `Ended`. Errors as in `capture`."""
    tape = link.line.tape
    if wishes.seconds is not None:
        link.ends = time.monotonic() + wishes.seconds
    try:
        yield PortOpened(port.name, link.line.protocol, tape.file)
        whole = yield from _to_the_end(link, port, settings, wishes, look)
        why = "complete" if whole and not link.open_ended else "it went silent"
    except Stopped as stopped:
        why, whole = str(stopped), link.open_ended and link.samples > 0
    except PortLost as lost:
        why, whole = str(lost), False
    except FieldkitError:
        raise
    except Exception:
        yield Instruction("an error in fieldkit; what the unit still sends is saved")
        yield from _kept(link, wishes.silence)
        raise
    finally:
        link.line.close()
    tape.note(ended=why, whole=whole)
    tape.close()
    yield link.progress()
    yield Ended(tape.file, link.line.protocol, tape.size, link.samples, link.damaged, why, whole, dict(link.about))


def _to_the_end(
    link: Link, port: Port, settings: PortSettings, wishes: CaptureOptions, look: ListPorts
) -> Dialogue[bool]:
    """Run the dialogue until a unit has sent everything, across reconnections; returns whether the capture is complete.

    Raises PortLost if the unit does not return, or is lost repeatedly without sending anything in between.
    """
    losses, at_loss = 0, -1
    while True:
        try:
            if not link.line.protocol:
                yield from _recognise(link, wishes)
            return (yield from _converse(link, wishes))
        except PortLost as lost:
            losses, at_loss = (losses + 1 if link.heard == at_loss else 0), link.heard
            if losses > MOST_LOSSES:
                raise
            link.line.tape.note(lost=str(lost))
            yield Lost(link.line.name, str(lost))
            link.line.close()
            link.forget()
            time.sleep(losses * PAUSE)
            link.line = yield from _reopened(link, port, settings, wishes.reconnect, look, lost)
            yield Back(link.line.name)


def _converse(link: Link, wishes: CaptureOptions) -> Dialogue[bool]:
    """Run the dialogue with a known unit, given the capture so far."""
    one = known_devices()[link.line.protocol]
    if one.invites:
        yield Instruction(one.invites)
    return (yield from one.dialogue(link, wishes, read_capture(link.line.tape.file)))


def _reopened(
    link: Link, unit: Port, settings: PortSettings, patience: float, look: ListPorts, lost: PortLost
) -> Dialogue[SerialLine]:
    """The line of a unit that has returned, with the settings at which it was understood, or else those given.

    Raises the loss again if it does not return.
    """
    tape, name = link.line.tape, link.line.protocol
    settings = link.line.settings if name else settings
    gives_up = time.monotonic() + patience
    while time.monotonic() < gives_up:
        if link.stop():
            raise Stopped("stopped")
        found = again(unit, look())
        if found is not None:
            try:
                line = open_line(found, name, settings, tape)
            except PortTrouble:
                pass  # it may take a moment until the system allows it to be opened
            else:
                tape.note(port=found)
                return line
        yield link.progress()
        time.sleep(0.1)
    raise lost


def _recognise(link: Link, wishes: CaptureOptions) -> Dialogue[None]:
    """Listen until the bytes can come from only one protocol, and continue with it. Raises PortTrouble."""
    yield Instruction("listening for a unit that sends unprompted; name one that only answers commands with --device")
    rates = [wishes.baud] if wishes.baud else list(RATES)
    patience = wishes.wait if wishes.wait is not None else PATIENCE
    heard, began, at_rate, nonsense = b"", time.monotonic(), 0, 0
    while time.monotonic() - began < patience:
        chunk = yield from link.hear()
        if not chunk:
            continue
        heard = (heard + chunk)[-RECOGNITION_BYTES:]
        names = [name for name, one in known_devices().items() if one.recognizes_stream(heard)]
        if len(names) == 1:
            _become(link, names[0], rates[at_rate], heard)
            yield Recognised(names[0])
            return
        nonsense += sum(byte in _NON_TEXT_BYTES for byte in chunk)
        if nonsense > 64 and len(rates) > 1:
            at_rate, nonsense, heard = (at_rate + 1) % len(rates), 0, b""
            link.line.retune(PortSettings(rates[at_rate]))
    what = "nothing" if not link.heard else f"{counted(link.heard, 'byte')} that match no protocol"
    names_of = ", ".join(known_devices())
    raise PortTrouble(f"{link.line.name}: received {what} in {patience:.0f} s; name the unit with --device: {names_of}")


_NON_TEXT_BYTES = frozenset(set(range(0x80, 0x100)) | set(range(0x09)) | set(range(0x0E, 0x20)))
"""Bytes that no text contains, which result from a wrong baud rate."""


def _become(link: Link, name: str, baud: int, heard: bytes) -> None:
    """Continue with a protocol at a rate [baud]; it gets the bytes received so far. Raises PortLost."""
    settings = replace(known_devices()[name].settings, baud=baud)
    link.line.retune(settings)
    link.line.protocol = name
    link.line.tape.note(device=name, settings=asdict(settings))
    link.push_back(heard)


def _kept(link: Link, silence: float | None) -> Dialogue[None]:
    """Save the incoming bytes without decoding them, until they stop."""
    with suppress(Stopped, PortLost):
        yield from link.drain(AFTER_A_FAULT if silence is None else silence, patience=float("inf"))
