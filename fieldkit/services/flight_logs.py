"""What the logs of flights show of thrust and drag, measured once and kept in the data folder.

To read and measure a log takes 0.2 to 0.4 s. The result depends on the bytes of the flight's files, on which flight in
them it is, on the columns that the user chose for a table, and on fieldkit's own code and tables; the digest of all
that names the file that keeps it. So whatever changes, nothing out of date is found. The folder may be deleted at any
time.
"""

import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.analysis import Forces
from fieldkit.analysis.force_profile import DragLikelihood, DragProfile, PortError
from fieldkit.errors import FieldkitError, LedgerError, UnusableLedger
from fieldkit.files import read, replace
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.paths import data_file
from fieldkit.plugins import plugin_folder
from fieldkit.progress import ReportProgress, no_op
from fieldkit.selection import logged_forces
from fieldkit.selection.logged_forces import FlightLog
from fieldkit.services.imports import stored_files
from fieldkit.services.replay import FlightRecordings
from fieldkit.shapes import Array, Float

MAX_LOGS = 500
"""Number of logs of which the measurements are kept, at most about 0.2 MB each. [1]"""
_MAX_SIZE = 4 << 20
"""Size limit of a file with measurements. [byte]"""
_CHECKSUM = sha256().digest_size
_OWN_NAME = re.compile(r"[0-9a-f]{64}|\.[0-9a-f]{40}\.[0-9a-f]{16}\.new")
"""Names of files with measurements, and of those that a killed process left; nothing else in the folder is touched."""
_FORCE_SAMPLES = tuple(name for name in Forces.__slots__ if name not in ("window", "source"))
"""The samples of forces."""


def flight_logs(
    ledger: Ledger, flights: Sequence[Flight], on_progress: ReportProgress = no_op
) -> dict[str, FlightLog | str]:
    """What the log of each flight that has one shows, by flight id, or the reason it cannot be read. Raises
    FieldkitError if saved choices of columns are needed and cannot be read."""
    logged = [flight for flight in flights if flight.has_log]
    found: dict[str, FlightLog | str] = {}
    recordings = FlightRecordings(ledger)
    for number, (flight, id) in enumerate(zip(logged, ledger.ids(logged), strict=True)):
        on_progress(f"the log of {id}", number / len(logged))
        try:
            log = flight_log(ledger, id, recordings)
        except UnusableLedger:
            raise
        except LedgerError as error:
            found[flight.flight_id] = str(error)
            continue
        if log is not None:
            found[flight.flight_id] = log
    return found


def flight_log(ledger: Ledger, id: str, recordings: FlightRecordings | None = None) -> FlightLog | None:
    """What the log of a flight of the ledger shows; None without a log, and for one that a simulator wrote.

    Raises LedgerError for an unknown id, and if it is unclear which flight of a log it is, FieldkitError if saved
    choices of columns are needed and cannot be read.
    """
    file = _file_of(ledger, id)
    if file is None:
        return None
    if (kept := _kept(file)) is not None:
        return kept
    recording = (recordings or FlightRecordings(ledger)).of(id)
    if recording is None or recording.reading is None or recording.kind == "simulation":
        return None
    log = logged_forces.flight_log(recording.reading.clocks, recording.recorded)
    with suppress(FieldkitError, OSError):  # it is measured again next time
        _keep(file, log)
    return log


def _file_of(ledger: Ledger, id: str) -> Path | None:
    """The file that keeps the measurements of a flight; None without a log."""
    files = stored_files(ledger, id)
    if files is None:
        return None
    flight = ledger.flight(id)
    which = repr((files.format, files.choices, flight.flight_id, flight.date_time, flight.origin.part))
    parts = [_program(), which.encode(), files.log, *files.others]
    return data_file("measured") / f"{sha256(b''.join(sha256(part).digest() for part in parts)).hexdigest()}"


@cache
def _program() -> bytes:
    """A digest of everything but the log that measurements depend on: fieldkit's code and tables, and
    the libraries that calculate."""
    package = Path(__file__).parents[1]
    files = {*package.rglob("*.py"), *package.glob("data/*.toml"), *plugin_folder("parsers").rglob("*.py")}
    versions = [version(name).encode() for name in ("numpy", "scipy", "pandas")]
    parts = [*versions, *(read(one) for one in sorted(files))]
    return sha256(b"".join(sha256(part).digest() for part in parts)).digest()


def _keep(file: Path, log: FlightLog) -> None:
    """Keep measurements, and drop others if they are too many: those whose names, which are digests, follow this one's.
    If the oldest were dropped, a ledger with a few more logs than are kept would find none of them when it reads them
    in order. Raises FieldkitError, OSError."""
    content = _written(log)
    replace(file, sha256(content).digest() + content)
    names = sorted(one.name for one in file.parent.iterdir() if _OWN_NAME.fullmatch(one.name))
    after = names.index(file.name) + 1
    for name in [*names[after:], *names[:after]][:-MAX_LOGS]:
        file.with_name(name).unlink(missing_ok=True)


def _kept(file: Path) -> FlightLog | None:
    """Kept measurements; None if there are none, or if their file is damaged."""
    try:
        content = read(file, plain=True, most=_MAX_SIZE)
    except OSError:
        return None
    checksum, content = content[:_CHECKSUM], content[_CHECKSUM:]
    return _log_of(content) if sha256(content).digest() == checksum else None


def _written(log: FlightLog) -> bytes:
    """Measurements as bytes: a line with the names, texts and shapes, then all numbers as they are in memory."""
    arrays, texts = {"liftoff_sd": _number(log.liftoff_sd)}, {}
    if log.forces is not None:
        arrays |= {name: np.asarray(getattr(log.forces, name), float) for name in _FORCE_SAMPLES}
        arrays["window"], texts["forces"] = _number(log.forces.window), log.forces.source
    if (drag := log.drag) is not None:
        each, texts["drag"] = drag.likelihoods, drag.source
        arrays |= {
            "coast": np.stack([drag.time_from_liftoff, drag.speed]),
            "units": np.array([drag.length, drag.reference]),
            "matrices": np.stack([[one.precision, one.prior] for one in each]),
            "vectors": np.stack([[one.shift, one.ports.joint] for one in each]),
            "numbers": np.array([[one.log_weight, one.ports.precision, one.ports.push] for one in each]),
        }
    shapes = {name: array.shape for name, array in arrays.items()}
    head = json.dumps({"shapes": shapes, "texts": texts}).encode()
    return b"\n".join([head, np.concatenate([array.ravel() for array in arrays.values()]).tobytes()])


def _log_of(content: bytes) -> FlightLog:
    """Measurements from their bytes."""
    head, _, rest = content.partition(b"\n")
    named = json.loads(head)
    sizes = [prod(shape) for shape in named["shapes"].values()]
    parts = np.split(np.frombuffer(rest), np.cumsum(sizes[:-1]))
    arrays = {name: part.reshape(shape) for (name, shape), part in zip(named["shapes"].items(), parts, strict=True)}
    forces, drag = named["texts"].get("forces"), named["texts"].get("drag")
    return FlightLog(
        None if forces is None else _forces_of(arrays, forces),
        _given(arrays["liftoff_sd"]),
        None if drag is None else _drag_of(arrays, drag),
    )


def _forces_of(arrays: Mapping[str, Array], source: str) -> Forces:
    sampled: dict[str, Any] = {name: arrays[name] for name in _FORCE_SAMPLES}
    sampled["burning"] = sampled["burning"] != 0
    return Forces(**sampled, window=_given(arrays["window"]), source=source)


def _drag_of(arrays: Mapping[str, Array], source: str) -> DragProfile:
    likelihoods = [
        DragLikelihood(log_weight, precision, shift, prior, PortError(joint, squared, push))
        for (precision, prior), (shift, joint), (log_weight, squared, push) in zip(
            arrays["matrices"], arrays["vectors"], arrays["numbers"].tolist(), strict=True
        )
    ]
    (time, speed), (length, reference) = arrays["coast"], arrays["units"].tolist()
    return DragProfile(time, length, speed, reference, tuple(likelihoods), source)


def _number(value: float | None) -> Float[Array, ""]:
    return np.array(np.nan if value is None else value)


def _given(value: Float[Array, ""]) -> float | None:
    return None if np.isnan(value) else float(value)
