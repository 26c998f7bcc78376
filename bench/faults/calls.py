"""System calls that fail: a command in its own process under strace, which makes its n-th call fail.

strace intercepts system calls, so those of SQLite's own code fail like Python's, and no part of the program is
replaced. A call that is only partly done, as on a disk that is nearly full, is produced with a file size limit instead,
which the system itself enforces.
"""

import fcntl
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from fieldkit.cli.main import main as run

GROUPS = {
    "open": ("open", "openat"),
    "read": ("read", "pread64"),
    "write": ("write", "pwrite64", "ftruncate"),
    "fsync": ("fsync", "fdatasync"),
    "rename": ("rename", "renameat", "renameat2", "link", "linkat"),
    "unlink": ("unlink", "unlinkat"),
}
"""System calls by purpose."""
CALLS = tuple(name for names in GROUPS.values() for name in names)
TRACEBACK = 99
"""Exit status of a command that ended in a traceback."""
HANGS = 98
"""Exit status of a command that was killed because it took too long."""
PATIENCE = 60.0
"""Least time limit of a command under a fault. [s]"""
FULL = "/dev/full"
"""A device on which nothing can be written."""
ROOM = 1 << 20
"""Size limit of a command's output. [byte]"""

EIO = "error=EIO"
WAYS = {"open": ("error=EMFILE", EIO), "read": (EIO, "retval=0"), "write": (EIO, "error=ENOSPC")}
"""How calls of a kind fail, in turn."""

_LINE = re.compile(r"^(?:\[pid\s+\d+\]\s+|\d+\s+)?(\w+)\((.*)$")


@dataclass(frozen=True, slots=True)
class Fault:
    """A failure of the n-th call of a name: `error=EIO`, `retval=0` (nothing read), `signal=SIGKILL`."""

    call: str
    number: int
    how: str

    def __str__(self) -> str:
        return f"{self.call} {self.number} {self.how}"


@dataclass(frozen=True, slots=True)
class Ended:
    """How a command ended: exit status, negative for a signal; its output; whether the fault occurred."""

    status: int
    out: str
    message: str
    came: bool


def can_trace() -> bool:
    """Whether strace is installed and may trace a process."""
    if shutil.which("strace") is None:
        return False
    return subprocess.run(["strace", "-qq", "-o", os.devnull, "true"], capture_output=True).returncode == 0


def run_with(
    work: Callable[[], int],
    folder: Path,
    notes: Path,
    fault: Fault | None = None,
    largest: int | None = None,
    *,
    full: bool = False,
    patience: float = PATIENCE,
) -> Ended:
    """Run some work in a fork, with a fault in its calls on files of `folder`; `notes` is a folder for logs.

    `largest` is a file size limit [byte]; with `full`, nothing can be written to the standard output. Work that takes
    longer than `patience` [s] counts as hanging.
    """
    ended = forked(folder, notes, fault, largest, full=full, patience=patience)
    if ended is None:
        leave(work)
    return ended


def forked(
    folder: Path,
    notes: Path,
    fault: Fault | None = None,
    largest: int | None = None,
    *,
    full: bool = False,
    patience: float = PATIENCE,
) -> Ended | None:
    """Fork, with a fault in the fork: how the fork ended, and None in the fork itself, which must call `leave`."""
    notes.mkdir(parents=True, exist_ok=True)
    pipes = [_pipe(), _pipe()]
    pid = os.fork()
    if not pid:
        try:
            _begin([os.open(FULL, os.O_WRONLY) if full else pipes[0][1], pipes[1][1]], largest)
        except BaseException:
            os._exit(TRACEBACK)
        return None
    tracer = _attached(pid, notes / "calls.txt", fault) if largest is None else None
    if tracer is None:
        os.waitpid(pid, os.WUNTRACED)
        os.kill(pid, signal.SIGCONT)
    status = _waited(pid, patience)
    if tracer is not None:
        tracer.wait(PATIENCE)
    trace = (notes / "calls.txt").read_text(errors="replace") if tracer is not None else ""
    came = any("(INJECTED)" in line and str(folder) in line for line in trace.splitlines())
    came |= status in (-signal.SIGKILL, HANGS)
    out, message = map(_poured, pipes)
    return Ended(status, out, message, came)


def leave(work: Callable[[], int]) -> NoReturn:
    """Do some work and end this process with its exit status."""
    status = TRACEBACK
    try:
        status = work()
        with suppress(OSError):  # the command has reported it
            sys.stdout.flush()
        sys.stderr.flush()
    except BaseException as error:
        os.write(2, f"Traceback: {type(error).__name__}: {error}\n".encode())
    os._exit(status)


def answer_of(work: Callable[[], str]) -> str:
    """What some work returns in a process of its own, which prints nothing; empty if that process died."""
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        os.close(reading)
        quiet()
        leave(lambda: _write_result(work, writing))
    os.close(writing)
    with os.fdopen(reading) as pipe:
        message = pipe.read()
    os.waitpid(pid, 0)
    return message


def _write_result(work: Callable[[], str], pipe: int) -> int:
    with os.fdopen(pipe, "w") as output:
        output.write(work())
    return 0


def quiet() -> None:
    """Print nothing from here on."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):
        os.dup2(nowhere, stream)


def _pipe() -> tuple[int, int]:
    """A pipe large enough for all of a command's output: the file size limit does not apply to it."""
    reading, writing = os.pipe()
    fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, ROOM)
    return reading, writing


def _poured(pipe: tuple[int, int]) -> str:
    """The content of a pipe whose writer has ended."""
    os.close(pipe[1])
    with os.fdopen(pipe[0], "rb") as reading:
        return reading.read().decode(errors="replace")


def _begin(streams: Sequence[int], largest: int | None) -> None:
    """Start of a forked process: redirect its output to pipes, and wait for the tracer."""
    for number, stream in enumerate(streams, start=1):
        os.dup2(stream, number)
    sys.stdout, sys.stderr = (os.fdopen(number, "w", encoding="utf-8", closefd=False) for number in (1, 2))
    if largest is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))
    os.kill(os.getpid(), signal.SIGSTOP)


def _attached(pid: int, log: Path, fault: Fault | None) -> "subprocess.Popen[bytes]":
    """Attach strace to a stopped process, which then continues."""
    os.waitpid(pid, os.WUNTRACED)
    log.unlink(missing_ok=True)
    command = ["strace", "-f", "-qq", "-y", "-s", "0", "-o", str(log), "-e", f"trace={','.join(CALLS)}"]
    command += ["-e", f"inject={fault.call}:{fault.how}:when={fault.number}"] if fault else []
    tracer = subprocess.Popen([*command, "-p", str(pid)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    status = Path(f"/proc/{pid}/status")
    while "TracerPid:\t0\n" in status.read_text(encoding="utf-8") and tracer.poll() is None:
        time.sleep(0.001)
    os.kill(pid, signal.SIGCONT)
    return tracer


def _waited(pid: int, patience: float) -> int:
    """Exit status of a process, negative for a signal; a process that takes too long is killed."""
    ends, late = time.monotonic() + patience, False
    while True:
        found, status = os.waitpid(pid, os.WNOHANG)
        if found:
            return HANGS if late else os.waitstatus_to_exitcode(status)
        if time.monotonic() > ends:
            late = True
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.002)


def made(notes: Path, folder: Path) -> list[tuple[str, int]]:
    """The calls of the last run on files of this folder: each name, with its count for that name so far."""
    counts: Counter[str] = Counter()
    found = []
    for line in (notes / "calls.txt").read_text(errors="replace").splitlines():
        if match := _LINE.match(line):
            counts[match[1]] += 1
            if str(folder) in match[2]:
                found.append((match[1], counts[match[1]]))
    return found


def faults(calls: Sequence[tuple[str, int]], reads: int, others: int) -> list[Fault]:
    """The faults: the process killed at each call that changes a file, and each call failed by the disk, every other
    write with a full disk; every other open finds too many files open, every other read returns nothing. At most
    `reads` opens and as many reads, and `others` calls of each other kind, spread evenly over the command.
    """
    chosen: list[Fault] = []
    for kind, names in GROUPS.items():
        changes = kind not in ("open", "read")
        some = _evenly([one for one in calls if one[0] in names], others if changes else reads)
        for place, (call, number) in enumerate(some):
            chosen.append(Fault(call, number, WAYS.get(kind, (EIO,) * 2)[place % 2 if call != "ftruncate" else 0]))
            if changes:
                chosen.append(Fault(call, number, "signal=SIGKILL"))
    return chosen


def _evenly(some: Sequence[tuple[str, int]], most: int) -> list[tuple[str, int]]:
    count = min(len(some), most)
    return [some[place * len(some) // count] for place in range(count)]


def command(ledger: Path, arguments: Sequence[str]) -> Callable[[], int]:
    """A command as a function to run."""
    return lambda: run(["--ledger", str(ledger), *arguments])
