"""Finds the motors whose recorded impulse is only nominal, and the impulse measured in tests.

    python tools/tested_impulses.py TESTS.csv thrustcurve-db.json

TESTS.csv has a row per test: manufacturer, designation, tested_impulse_ns, tested_peak_n, source and note, if the
note begins with `basis=letter`, `basis=stated` or `basis=curve` and states the `file class`. Printed are rows of
`fieldkit/data/motor_corrections.csv`.

The rule: an impulse is nominal if it is the upper limit of its class (2.5, 5, 10 ... N s). It gives way to the best
test (a letter before stated figures before a certified curve before any other; of equals the one whose peak thrust is
nearest to the certified one) unless a test of that rank agrees with it within two standard deviations of tests of
one motor. That standard deviation is measured on the same table.
"""

import argparse
import csv
import json
import math
import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import fmean, median
from typing import Any

ROUNDING = 5e-4
"""The source has four significant digits. [1]"""
OTHER = 3
"""Rank of a curve whose file is not of the class of certifications."""

Test = dict[str, str]
Motor = dict[str, Any]


def rank(test: Test) -> int:
    """The rank of a test: 0 for a letter, 1 for stated figures, 2 for a certified curve, 3 for any other."""
    note = test["note"]
    for place, basis in enumerate(("basis=letter", "basis=stated")):
        if note.startswith(basis):
            return place
    return 2 if "file class cert" in note else OTHER


def nominal(total_impulse: float) -> bool:
    """Whether an impulse [N s] is the upper limit of a class, to the digits of the source."""
    classes = math.log2(total_impulse / 2.5)
    return abs(total_impulse / (2.5 * 2.0 ** round(classes)) - 1) < ROUNDING


def scatter(tests: Iterable[Test]) -> float:
    """Robust standard deviation of the impulse in tests of one motor, relative. [1]

    From the median absolute deviation about each motor's mean of letters, stated figures and certified curves.
    """
    by_motor: dict[tuple[str, str], set[float]] = defaultdict(set)
    for test in tests:
        if rank(test) < OTHER:
            by_motor[test["manufacturer"], test["designation"]].add(math.log(float(test["tested_impulse_ns"])))
    several = [sorted(values) for values in by_motor.values() if len(values) > 1]
    deviations = [abs(v - fmean(ones)) * math.sqrt(len(ones) / (len(ones) - 1)) for ones in several for v in ones]
    return 1.4826 * median(deviations)


def replacement(motor: Motor, tests: Sequence[Test], sd: float) -> Test | None:
    """The test whose impulse replaces that of a motor; None if the motor's own stays."""
    total = motor["totImpulseNs"]
    if not tests or not nominal(total):
        return None
    best = [test for test in tests if rank(test) == min(map(rank, tests))]
    if any(abs(math.log(float(test["tested_impulse_ns"]) / total)) <= 2 * sd for test in best):
        return None
    return min(best, key=lambda test: abs(float(test["tested_peak_n"]) - (motor.get("maxThrustN") or 0.0)))


def main() -> None:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    arguments.add_argument("tests", type=Path, help="a table of tests")
    arguments.add_argument("motors", type=Path, help="thrustcurve-db.json")
    options = arguments.parse_args()
    with options.tests.open(encoding="utf-8", newline="") as file:
        tests = list(csv.DictReader(file))
    sd = scatter(tests)
    print(f"tests of one motor scatter by {sd:.1%}", file=sys.stderr)
    rows = csv.writer(sys.stdout, lineterminator="\n")
    for motor in json.loads(options.motors.read_text(encoding="utf-8")):
        own = [test for test in tests if _same(test, motor)]
        if test := replacement(motor, own, sd):
            value = f"{float(test['tested_impulse_ns']):g}"
            maker, name = motor["manufacturerAbbrev"], motor["designation"]
            rows.writerow([maker, name, "total_impulse_ns", motor["totImpulseNs"], value, "sure", test["source"]])


def _same(test: Test, motor: Motor) -> bool:
    """Whether a test is of a motor; makers are written in full in both."""
    return (test["manufacturer"], test["designation"]) == (motor["manufacturer"], motor["designation"])


if __name__ == "__main__":
    main()
