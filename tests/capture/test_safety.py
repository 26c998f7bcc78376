"""No code path can send a command that fires, erases, arms or writes, or anything else that is not in the table."""

import ast
import random
import re
from collections.abc import Callable, Iterator
from functools import cache
from itertools import count
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.capture import CaptureOptions, Port, known_devices
from fieldkit.capture.captured import Captured
from fieldkit.capture.commands import ALLOWED_COMMANDS, ForbiddenCommand, allowed
from fieldkit.capture.line import PortSettings, SerialLine
from fieldkit.capture.link import Link, Stopped
from fieldkit.capture.tape import Tape, begin
from fieldkit.errors import FieldkitError
from tests.capture.devices import IDENTITY, altos_lines, raven_frame, sentence, telem, telem_sensor
from tests.effort import examples

ROOT = Path(__file__).parents[2]

FORBIDDEN = [
    # MAWD: fires the drogue and the main output; continuity beeps, reboot; writes its settings
    *(b"FD", b"FM", b"F", b"FDFM", b"C", b"R", b"A0", b"A1", b"T0", b"T1", b"L09", b"A\r", b"T\r", b"L\r"),
    # AltiMulti: fires an output, erases all, deletes the last, and what writes
    *(b"k;", b"k1;", b"k1 fire;", b"e;", b"x;", b"d;", b"t;", b"p;", b"q;", b"w;", b"z;", b"w1,2;", b"r25;", b"a;"),
    *(b"h;e;", b"r1;k1;", b"e", b"k", b"s;", b"c;", b"i;", b"m;"),
    # AltOS: igniter test, erases a flight, saves or resets settings, arms, reboots, turns the radio on to transmit
    *(b"i\n", b"i 0\n", b"i DoIt main\n", b"d 1\n", b"d all\n", b"c w\n", b"c r\n", b"c m 200\n", b"c A 1\n", b"c P\n"),
    *(b"a 1\n", b"a DoIt\n", b"r\n", b"r eboot\n", b"z\n", b"Z DoIt\n", b"C 1\n", b"p\n", b"R\n", b"w 0\n", b"O\n"),
    *(b"e 10\ni 0\n", b"v\nd 1\n", b"e 10", b"e 10;\n", b"e \n", b"m 20", b"c F 434550\nc w\n", b"E 1\n"),
    # Blue Raven: erases, simulates a flight, tests the outputs
    *(b"erase data\r\n", b"erase data", b"start sim\r\n", b"start sim", b"deploy test\r\n", b"get deploy\r\n"),
    *(b"download l\r\nerase data\r\n", b"arm\r\n"),
    # an empty string is a command too
    *(b"", b"\n", b";", b"\r\n", b"\x00", b"\xff" * 40),
]
"""Commands that must never be sent, from the manufacturers' tables and their combinations."""

LETTERS = {
    "altimulti": rb"(?:[hbnrfg]|y)[0-9]{0,2};",
    "altos": rb"(?:~|E 0|c s|f|v|l|e [0-9a-f]+)\n",
    "teledongle": rb"(?:~|E 0|v|c F [0-9]{6}|m 20|m 0)\n",
    "blue_raven": rb"download [lh]\r\n",
    "mawd": rb"[IVSD]",
}
"""Harmless commands in the manufacturers' tables, listed a second time."""


class Ear:
    """A port that records what was written to it and sends prepared answers."""

    baudrate, xonxoff = 9600, False

    def __init__(self, reply: Callable[[bytes], bytes]) -> None:
        self.reply = reply
        self.written: list[bytes] = []
        self.waiting = b""
        self.in_waiting = 0

    def write(self, command: bytes) -> int:
        self.written.append(bytes(command))
        self.waiting += self.reply(command)
        return len(command)

    def read(self, _: int) -> bytes:
        answer, self.waiting = self.waiting, b""
        return answer

    def close(self) -> None:
        return


def silent(_: bytes) -> bytes:
    return b""


@pytest.fixture(scope="module")
def tape(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tape]:
    with begin(tmp_path_factory.mktemp("captures"), {}) as tape:
        yield tape


@pytest.mark.parametrize("protocol", [*known_devices(), "", "unknown"])
def test_a_command_that_does_more_than_read_is_refused(tape: Tape, protocol: str) -> None:
    for command in FORBIDDEN:
        ear = Ear(silent)
        with pytest.raises(ForbiddenCommand):
            SerialLine("port", protocol, PortSettings(), tape, ear).send(command)
        assert not ear.written


@given(
    protocol=st.sampled_from([*ALLOWED_COMMANDS, "eggtimer", ""]),
    command=st.binary(max_size=12) | st.from_regex(r"[a-zA-Z~][ -~]{0,6}[;\n]").map(str.encode),
)
@examples(50)
def test_whatever_is_passed_to_send_only_commands_in_the_table_are_written(
    tape: Tape, protocol: str, command: bytes
) -> None:
    ear = Ear(silent)
    try:
        SerialLine("port", protocol, PortSettings(), tape, ear).send(command)
    except ForbiddenCommand:
        assert not ear.written
    else:
        assert ear.written == [command]
        assert re.fullmatch(LETTERS[protocol], command)


@given(data=st.data(), protocol=st.sampled_from([*ALLOWED_COMMANDS]))
@examples(50)
def test_every_command_in_the_table_is_a_read_command_of_the_manufacturers(protocol: str, data: st.DataObject) -> None:
    command = data.draw(st.from_regex(ALLOWED_COMMANDS[protocol], fullmatch=True))
    assert re.fullmatch(LETTERS[protocol], command)
    assert command not in FORBIDDEN


@examples(30)
@given(letters=st.lists(st.from_regex(ALLOWED_COMMANDS["mawd"], fullmatch=True)))
def test_letters_sent_to_a_mawd_never_form_a_command_that_fires(letters: list[bytes]) -> None:
    assert not re.search(rb"F|A|T|L|C|R", b"".join(letters))


def test_a_passive_protocol_may_send_nothing() -> None:
    for protocol in set(known_devices()) - set(ALLOWED_COMMANDS):
        assert not any(allowed(protocol, bytes([byte])) for byte in range(256))
    assert set(ALLOWED_COMMANDS) <= set(known_devices())
    assert {"micropeak", "stratologger", "eggtimer"} == set(known_devices()) - set(ALLOWED_COMMANDS)


# --- The code itself


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"))


@cache
def modules() -> list[Path]:
    return sorted(
        [*(ROOT / "fieldkit").rglob("*.py"), *(ROOT / "parsers").rglob("*.py"), *(ROOT / "models").rglob("*.py")]
    )


def imported(tree: ast.AST) -> set[str]:
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {name.name.split(".")[0] for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
            name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            text = node.args[0].value if node.args and isinstance(node.args[0], ast.Constant) else ""
            if name in ("import_module", "__import__") and isinstance(text, str):
                found.add(text.split(".")[0])
    return found


@pytest.mark.thorough
def test_only_two_modules_use_serial_ports_and_one_of_them_only_lists_them() -> None:
    owners = {path.relative_to(ROOT).as_posix() for path in modules() if "serial" in imported(parsed(path))}
    assert owners == {"fieldkit/capture/line.py", "fieldkit/capture/port.py"}
    lister = parsed(ROOT / "fieldkit/capture/port.py")
    taken = [node for node in ast.walk(lister) if isinstance(node, ast.ImportFrom) and node.module == "serial.tools"]
    assert [name.name for node in taken for name in node.names] == ["list_ports"]
    assert not {"Serial", "serial_for_url"} & {
        node.attr for node in ast.walk(lister) if isinstance(node, ast.Attribute)
    }


def test_no_other_module_opens_a_terminal() -> None:
    for path in (ROOT / "fieldkit" / "capture").rglob("*.py"):
        tree = parsed(path)
        assert not {"fcntl", "pty", "tty", "subprocess", "socket", "ctypes", "serial_asyncio"} & imported(tree), path
        taken = {
            name.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module == "termios"
            for name in node.names
        }
        assert taken <= {"error"}


WRITERS = {"write", "writelines", "sendall", "send_break", "break_condition", "write_timeout", "fileno", "fd", "ioctl"}


def functions(tree: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            yield node.name, node


def attributes(tree: ast.AST) -> list[str]:
    return [node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)]


def test_only_one_function_writes_to_a_port_and_it_checks_the_table_first() -> None:
    """The port is `Line._port`, which no other module touches; `write` is called on it once, in `send`."""
    for path in (ROOT / "fieldkit" / "capture").rglob("*.py"):
        tree = parsed(path)
        if path.name != "line.py":
            assert "_port" not in attributes(tree), path
            assert "getattr" not in {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}, path
        if path.name not in ("line.py", "tape.py"):
            assert not WRITERS & set(attributes(tree)), path
    line = parsed(ROOT / "fieldkit/capture/line.py")
    assert [name for name in attributes(line) if name in WRITERS] == ["write"]
    (send,) = [node for name, node in functions(line) if name == "send"]
    assert [name for name in attributes(send) if name in WRITERS] == ["write"]
    body = [node for node in send.body if not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))]
    assert ast.unparse(body[0].test) == "not allowed(self.protocol, command)"
    assert isinstance(body[0].body[0], ast.Raise)
    (writing,) = [
        node for node in ast.walk(send) if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(".write")
    ]
    assert ast.unparse(writing) == "self._port.write(command)"
    assert not [node for node in ast.walk(send) if isinstance(node, ast.Assign | ast.AugAssign | ast.NamedExpr)]


def test_no_other_module_uses_the_private_attributes_of_a_line() -> None:
    for path in modules():
        if (ROOT / "fieldkit" / "capture") not in path.parents and "_port" in path.read_text("utf-8"):
            assert "_port" not in attributes(parsed(path)), path


# --- Conversations with units that answer anything


RIGHT = {
    "altimulti": {b"h;": b"$OK;", b"b;": b"$end;", b"n;": sentence("nbrOfFlight", 3) + b"$end;", b"r": b"$start;$end;"},
    "altos": {
        b"v": IDENTITY,
        b"l": b"flight 1 start 0 end 2\nflight 2 start ffff end 10001\ndone\n",
        b"e": b"".join(altos_lines(bytes(range(256)))),
    },
    "teledongle": {b"v": IDENTITY, b"m": telem(telem_sensor(1, 2, 3))},
    "blue_raven": {b"d": raven_frame("LOG_LOW", 1, "V: 1") + raven_frame("LOG_HIR", 1, "V: 1")},
    "mawd": {b"I": b"\r\na\r\nb\r\n", b"V": b"1\r\n", b"S": b"G00001\r\nA00001\r\nN00001\r\nD00001\r\nM00001\r\n"},
}
"""Answers of units to commands with these beginnings."""
ODD = [
    b"$OK;",
    b"$KO;",
    b"$UNKNOWN;e;",
    b"FD",
    b"FM\r\n",
    b"e;k1;",
    b"i 0\n",
    b"start sim\r\n",
    b"\xff" * 9,
    b"$",
    b"done\n",
]
REACHED = {
    "altimulti": b"r1;",
    "altos": b"e 10000\n",
    "teledongle": b"m 0\n",
    "blue_raven": b"download h\r\n",
    "mawd": b"D",
}


@pytest.fixture
def _hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Time runs fast, so that waiting for an answer ends soon."""
    clock = count(step=0.02)
    monkeypatch.setattr("fieldkit.capture.link.time.monotonic", lambda: next(clock))


@pytest.mark.usefixtures("_hasty")
@pytest.mark.parametrize("name", [*known_devices()])
def test_no_answer_makes_a_protocol_send_anything_else(tape: Tape, name: str) -> None:
    sent: set[bytes] = set()
    for seed in range(20):
        rng = random.Random(seed)

        def reply(command: bytes, rng: random.Random = rng) -> bytes:
            right = RIGHT.get(name, {}).get(command[:1], b"") or RIGHT.get(name, {}).get(command, b"")
            return right if rng.random() < 0.8 else rng.choice([*ODD, right[: rng.randrange(9)], rng.randbytes(30)])

        ear = Ear(reply)
        patience = count()
        link = Link(
            SerialLine("port", name, PortSettings(), tape, ear), lambda patience=patience: next(patience) > 5000
        )
        wishes = CaptureOptions(
            lambda flights: [-3, 2**40, *(f.number for f in flights)], seed % 3 == 0, 434.55e6, wait=5, silence=5
        )
        try:
            for _ in known_devices()[name].dialogue(link, wishes, Captured(tape.file, b"")):
                pass
        except (Stopped, FieldkitError):
            pass
        sent.update(ear.written)
    assert all(re.fullmatch(LETTERS[name], command) for command in sent)
    assert REACHED.get(name, b"") in (sent or {b""})


def test_a_port_has_no_protocol_until_one_is_named() -> None:
    assert Port("/dev/ttyUSB0", 0x0403, 0x6015).device == ""
    assert Port("/dev/ttyUSB0", 0x0483, 0x5740).device == ""
    assert Port("/dev/ttyACM0", 0xFFFE, 0x000B).device == "altos"
    assert Port("/dev/ttyACM0", 0xFFFE, 0x000C).device == "teledongle"
    assert Port("/dev/ttyACM0", 0xFFFE, 0x002B).device == "micropeak"
    assert Port("/dev/ttyACM0", 0xFFFE, 0x0100).device == ""
