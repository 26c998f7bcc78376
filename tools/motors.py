"""Turns the npm package `thrustcurve-db` into the catalog that fieldkit ships.

    python tools/motors.py [thrustcurve-db.json]

Without a path the pinned version is fetched with `npm pack`. The same input gives the same bytes. Figures that
documents correct (`fieldkit/data/motor_corrections.csv`) are replaced before anything else, and motors that are newer
than the package (`fieldkit/data/motor_additions.csv`) added with a curve made from their certification letters. A
curve whose burn time, average or peak thrust is not the certified one is replaced by another (`fieldkit/data/
motor_curves.csv`), or reshaped to the certified figures (`fieldkit.motors.record`), and marked. Motors
without samples, or whose samples disagree with the certified impulse, are left out and listed; a mass that is missing
is estimated by the rules of `motor_masses` and marked.
"""

import argparse
import csv
import gzip
import hashlib
import json
import subprocess
import tarfile
import tempfile
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

from fieldkit.errors import BadValue
from fieldkit.motors.catalogue import DATA
from fieldkit.motors.corrections import DATA as CORRECTIONS
from fieldkit.motors.corrections import QUANTITIES, Correction, as_rows, read_corrections
from fieldkit.motors.motor import impulse, knots
from fieldkit.motors.record import AGREEMENT, CertifiedRecord, agreement, reshaped, states_whole_burn, with_peak
from fieldkit.shapes import Array
from tools.motor_masses import Row, estimate_casing, estimate_propellant, unfit

PACKAGE, VERSION = "thrustcurve-db", "3.0.4"
STATES_WHOLE_BURN = "National Association of Rocketry"
"""The certifying organization that mostly states burn times from ignition to the end of thrust; others those above 5%
of the peak thrust."""
IMPULSE_TOLERANCE = 0.25
"""Samples are left out if their impulse differs from the certified one by more than this fraction. [1]"""
SOURCE_KEYS = {
    "total_impulse_ns": "totImpulseNs",
    "average_n": "avgThrustN",
    "peak_n": "maxThrustN",
    "burn_s": "burnTimeS",
    "propellant_g": "propWeightG",
    "loaded_g": "totalWeightG",
    "length_mm": "length",
    "designation": "designation",
    "name": "commonName",
    "class": "impulseClass",
    "delays": "delays",
}
"""Fields of a correction as the package names them."""

ADDITIONS = CORRECTIONS.with_name("motor_additions.csv")
"""Motors that are newer than the package."""
CURVES = CORRECTIONS.with_name("motor_curves.csv")
"""Curves that replace one of the package."""
PEAK, FALLING = 0.1, 0.75
"""Time of the peak of an estimated curve, and duration of the slow decline after it, as fractions of the burn. [1]"""

EXACT = 0.002
"""How near the figures of a reshaped curve are to their record, beyond what the record contradicts itself. [1]"""

Corrections = Mapping[tuple[str, str], Sequence[Correction]]


def fetch(folder: Path) -> Path:
    """The data of the pinned package, downloaded into a folder."""
    subprocess.run(["npm", "pack", "--silent", f"{PACKAGE}@{VERSION}"], cwd=folder, check=True)
    with tarfile.open(next(folder.glob("*.tgz"))) as archive:
        archive.extractall(folder, filter="data")
    return folder / "package" / f"{PACKAGE}.json"


def corrected(motors: list[Row], corrections: Corrections) -> list[Row]:
    """The motors of the source with every correction that is not open applied, and all corrections noted.

    Raises BadValue for a correction of a motor that is missing, or of a figure whose value has changed.
    """
    if strange := sorted(set(corrections) - set(map(_key, motors))):
        raise BadValue(f"{CORRECTIONS.name}: found no motor {' '.join(strange[0])} in the source")
    return [_corrected(motor, corrections.get(_key(motor), ())) for motor in motors]


def _key(motor: Row) -> tuple[str, str]:
    return motor["manufacturerAbbrev"], motor["designation"]


def _corrected(motor: Row, corrections: Sequence[Correction]) -> Row:
    changed = motor | {"corrections": as_rows(corrections)}
    for one in corrections:
        before = motor.get(SOURCE_KEYS[one.field])
        if one.was != ("" if before is None else str(before)):
            raise BadValue(f"{motor['designation']}, {one.field}: found {before}, expected {one.was or 'none'}")
        if one.applied:
            changed[SOURCE_KEYS[one.field]] = float(one.value) if one.field in QUANTITIES else one.value
    return changed


def row(motor: Row) -> Row:
    """A motor of the source with the names and the knots of the catalog; masses may be None yet. Raises BadValue with
    the reason if its samples are unusable."""
    if not motor.get("samples"):
        raise BadValue("no samples")
    time, thrust = knots(*zip(*_in_order(motor["samples"]), strict=True))
    ratio = impulse(time, thrust) / motor["totImpulseNs"]
    if abs(ratio - 1) > IMPULSE_TOLERANCE:
        raise BadValue("impulse of the samples off the certified one by more than 25%")
    time, thrust, origin = certified_curve(motor, time, thrust)
    total = motor.get("totalWeightG")
    propellant = motor.get("propWeightG")
    return {
        "maker": motor["manufacturerAbbrev"],
        "name": motor["commonName"],
        "designation": motor["designation"],
        "class": motor["impulseClass"],
        "kind": motor["type"],
        "diameter_mm": motor["diameter"],
        "length_mm": motor["length"],
        "total_impulse_ns": motor["totImpulseNs"],
        "average_n": certified_average(motor),
        "peak_n": motor.get("maxThrustN"),
        "burn_s": motor["burnTimeS"],
        "curve_origin": origin,
        "propellant_g": propellant or None,
        "casing_g": round(total - propellant, 4) if total and propellant else None,
        "total_g": total or None,
        "delays": delays(motor.get("delays") or ""),
        "available": motor["availability"] == "regular",
        "case": motor.get("caseInfo") or "",
        "propellant": motor.get("propInfo") or "",
        "url": motor.get("infoUrl") or "",
        "estimated": list(motor.get("estimated", [])),
        "corrections": motor.get("corrections", []),
        "curve": " ".join(f"{t:.7g} {f:.7g}" for t, f in zip(time, thrust, strict=True)),
    }


def certified_curve(motor: Row, time: Array, thrust: Array) -> tuple[Array, Array, str]:
    """The curve of a motor and its origin: the recorded one (empty) if it agrees with the record once it is scaled to
    the certified impulse, else that reshaped to the record. A certified peak that it cannot have is left."""
    total, certifier = motor["totImpulseNs"], motor.get("certOrg", "")
    record = CertifiedRecord(total, motor["burnTimeS"], certified_average(motor), motor.get("maxThrustN"))
    scaled = thrust * (total / impulse(time, thrust))
    found = agreement(time, scaled, record)
    origin = motor.get("curveOrigin", "")
    if found.largest <= AGREEMENT:
        return time, thrust, origin
    whole, near = certifier.startswith(STATES_WHOLE_BURN) and states_whole_burn(time, scaled, record), AGREEMENT
    if abs(found.deviation) > AGREEMENT:
        time, scaled = reshaped(time, thrust, record, whole=whole)
        origin = f"recorded curve of {found.burn:.3g} s reshaped to the certified burn time of {record.burn:.3g} s"
        near = abs(agreement(time, scaled, record).deviation) + EXACT
    if abs(agreement(time, scaled, record).peak_deviation or 0.0) <= AGREEMENT:
        return time, scaled, origin
    if (peaked := _with_peak(time, scaled, record, whole=whole, near=near)) is None:
        return time, scaled, origin
    peak = f"the certified peak of {record.peak:.4g} N"
    before = f"recorded curve with a peak of {found.peak:.4g} N reshaped to {peak}"
    return *peaked, f"{origin} and to {peak}" if origin else before


def _with_peak(
    time: Array, thrust: Array, record: CertifiedRecord, *, whole: bool, near: float
) -> tuple[Array, Array] | None:
    """A curve with the peak of its record too. Its burn time is restored while 5% of another peak takes a figure
    farther than `near` from the record. None if it cannot have both."""
    for _ in range(20):
        if (peaked := with_peak(time, thrust, record)) is None or abs(agreement(*peaked, record).deviation) <= near:
            return peaked
        time, thrust = reshaped(*peaked, record, whole=whole)
    return None


def read_curves(table: Path = CURVES) -> dict[tuple[str, str], Row]:
    """The curves of a table by maker and designation: their samples, and their origin."""
    with table.open(encoding="utf-8", newline="") as file:
        return {(one["maker"], one["designation"]): _curve(one) for one in csv.DictReader(file)}


def _curve(one: Mapping[str, str]) -> Row:
    numbers = [float(word) for word in one["curve"].split()]
    samples = [[0.0, 0.0], *map(list, zip(numbers[::2], numbers[1::2], strict=True))]
    return {"samples": samples, "curveOrigin": f"another curve: {one['source']}"}


def certified_average(motor: Row) -> float | None:
    """The average thrust that the source states; None if it only repeats the number in the name. [N]"""
    stated: float | None = motor.get("avgThrustN")
    number = motor["commonName"].lstrip("1/248").lstrip("ABCDEFGHIJKLMNO")
    return None if stated is None or f"{stated:g}" == number else stated


def _in_order(samples: list[list[float]]) -> list[list[float]]:
    """The samples; in two curves, the final zero precedes the last thrust at the same time."""
    *rest, before, last = samples
    swapped = before[0] == last[0] and before[1] == 0
    return [*rest, last, before] if swapped else samples


def delays(text: str) -> list[float | str]:
    """`0,3,5,7,P` as numbers and P; delays named only short, medium and long are left out."""
    words = [word for word in text.split(",") if word.isdigit() or word == "P"]
    return [int(word) if word.isdigit() else word for word in words]


def additions(table: Path = ADDITIONS) -> list[Row]:
    """Motors with a certification letter that are missing in the source, in the source's format.

    The thrust rises to its peak within a tenth of the burn, declines linearly for three quarters of it to the value
    that gives the impulse, and then to zero. Impulse, peak and burn time are those of the letter; the shape is
    estimated. Raises BadValue for figures that no such curve has.
    """
    with table.open(encoding="utf-8", newline="") as file:
        return [_added(one) for one in csv.DictReader(file)]


def falling(total: float, peak: float, burn: float) -> list[list[float]]:
    """The estimated curve [s, N] of an impulse [N s], a peak [N] and a burn time [s]. Raises BadValue without one."""
    later = (total / (peak * burn) - (PEAK + FALLING) / 2) / ((1 - PEAK) / 2)
    if not 0 < later <= 1:
        raise BadValue(f"found a peak of {peak:g} N and {total:g} N s, expected a falling curve")
    return [[0.0, 0.0], [PEAK * burn, peak], [(PEAK + FALLING) * burn, later * peak], [burn, 0.0]]


def _added(one: dict[str, str]) -> Row:
    total, peak, burn = (float(one[key]) for key in ("total_impulse_ns", "peak_n", "burn_s"))
    try:
        samples = falling(total, peak, burn)
    except BadValue as error:
        raise BadValue(f"{one['designation']}: {error}") from None
    return {
        "motorId": one["designation"],
        "manufacturerAbbrev": one["maker"],
        "commonName": one["name"],
        "designation": one["designation"],
        "impulseClass": one["class"],
        "type": one["kind"],
        "diameter": float(one["diameter_mm"]),
        "length": float(one["length_mm"]),
        "totImpulseNs": total,
        "avgThrustN": float(one["average_n"]),
        "maxThrustN": peak,
        "burnTimeS": burn,
        "propWeightG": float(one["propellant_g"]),
        "totalWeightG": float(one["loaded_g"]),
        "propInfo": one["propellant"],
        "delays": one["delays"],
        "availability": "regular",
        "updatedOn": "",
        "samples": samples,
        "estimated": ["thrust curve", "diameter"],
        "corrections": as_rows([Correction("motor", "", "added", "likely", one["source"])]),
    }


def build(
    motors: list[Row],
    digest: str,
    corrections: Corrections | None = None,
    added: Sequence[Row] = (),
    curves: Mapping[tuple[str, str], Row] | None = None,
) -> Row:
    """The catalog as one document: its source, what was left out, and a row per motor. `curves` replace those of the
    source."""
    rows: list[Row] = []
    left_out: dict[str, list[str]] = defaultdict(list)
    corrections = corrections or {}
    others = curves or {}
    motors = [motor | others.get(_key(motor), {}) for motor in corrected(motors, corrections)] + list(added)
    for motor in sorted(motors, key=lambda motor: motor["motorId"]):
        try:
            rows.append(row(motor))
        except BadValue as error:
            left_out[str(error)].append(f"{motor['manufacturerAbbrev']} {motor['designation']}")
    estimate_propellant(rows)
    estimate_casing(rows)
    for entry in rows:
        if why := unfit(entry):
            left_out[why].append(f"{entry['maker']} {entry['designation']}")
    kept = [entry for entry in rows if not unfit(entry)]
    columns = [column for column in kept[0] if column != "total_g"]
    return {
        "source": f"ThrustCurve.org by way of {PACKAGE} {VERSION}",
        "url": "https://www.thrustcurve.org",
        "package": PACKAGE,
        "version": VERSION,
        "date": max(motor["updatedOn"] for motor in motors),
        "licence": "ISC (package by Robert Kieffer); data of ThrustCurve.org by John Coker and contributors",
        "sha256": digest,
        "read": len(motors),
        "kept": len(kept),
        "by_class": {
            letter: [count, Counter(entry["class"] for entry in kept)[letter]]
            for letter, count in sorted(Counter(motor["impulseClass"] for motor in motors).items())
        },
        "by_maker": dict(Counter(entry["maker"] for entry in kept).most_common()),
        "estimated": dict(sorted(Counter(what for entry in kept for what in entry["estimated"]).items())),
        "corrections": dict(Counter(one.confidence for ones in corrections.values() for one in ones).most_common()),
        "left_out": dict(sorted(left_out.items())),
        "columns": columns,
        "motors": [[entry[column] for column in columns] for entry in kept],
    }


def packed(document: Row) -> bytes:
    """The document as compressed JSON, the same bytes for the same document."""
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":"))
    return gzip.compress(text.encode(), compresslevel=9, mtime=0)


def main() -> None:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    arguments.add_argument("data", nargs="?", type=Path, help="thrustcurve-db.json; fetched when not given")
    arguments.add_argument("--out", type=Path, default=DATA)
    options = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        source = (options.data or fetch(Path(folder))).read_bytes()
    document = build(
        json.loads(source), hashlib.sha256(source).hexdigest(), read_corrections(), additions(), read_curves()
    )
    options.out.write_bytes(packed(document))
    counts = {why: len(names) for why, names in document["left_out"].items()}
    print(f"{options.out}: {document['kept']} of {document['read']} motors; left out {counts}")
    print(f"estimated {document['estimated']}")


if __name__ == "__main__":
    main()
