"""What `fieldkit motors --check`, `--compare` and `--corrections` print: the catalog, records and tables of figures."""

from pathlib import Path
from typing import TYPE_CHECKING

from fieldkit.cli.screen import complain, print_json, print_table, say, say_wrapped
from fieldkit.cli.session import known_motors
from fieldkit.paths import motor_folder
from fieldkit.quantities import counted, rounded

if TYPE_CHECKING:
    from fieldkit.motors import Motor

MAX_DIFFERENCES = 40
"""Maximum number of differences in a table. [1]"""


def print_comparison(file: Path, json: bool) -> None:
    """Print the figures that differ from a table of tests, largest difference first."""
    from fieldkit.motors.comparison import compare_tests
    from fieldkit.motors.corrections import QUANTITIES
    from fieldkit.motors.motor import delays_text
    from fieldkit.services.imports import read_file

    found = compare_tests(known_motors(), read_file(file), file.name)
    if json:
        counts = {"rows": found.rows, "motors": found.motors, "unknown": found.unknown}
        figures, delays = ([one.json() for one in ones] for ones in (found.differences, found.delays))
        print_json({**counts, "differences": figures, "delays": delays})
        return
    rows = [
        (
            f"{one.motor.maker} {one.motor.designation}",
            f"{QUANTITIES[one.field][0]}, {one.unit}",
            rounded(one.listed),
            rounded(one.tested),
            f"{one.ratio:+.0%}",
            one.basis,
        )
        for one in found.differences[:MAX_DIFFERENCES]
    ]
    headers = ("motor", "figure", "catalog", "tested", "off", "basis")
    print_table(headers, rows, numbers=headers[2:5])
    for one in found.delays:
        motor = f"{one.motor.maker} {one.motor.designation}"
        listed, tested = delays_text(one.motor.delays), delays_text(one.tested)
        say(f"{motor}: delays {listed}; tested {tested} ({one.basis or 'test'})")
    complain(
        f"{counted(found.rows, 'test')} of {counted(found.motors, 'motor')}; "
        f"differences of more than 5%: {len(found.differences)}"
    )
    if len(found.differences) > MAX_DIFFERENCES:
        complain(f"the {MAX_DIFFERENCES} largest differences are listed, --json has all")
    if found.unknown:
        complain(f"not in the catalog: {', '.join(found.unknown[:5])}{' and more' if len(found.unknown) > 5 else ''}")


def print_records(motors: "list[Motor]", json: bool) -> None:
    """Print every thrust curve beside its certified record, largest deviation first."""
    from fieldkit.motors.record import AGREEMENT, checked, document, used_curve

    found = checked(motors)
    if json:
        print_json({"motors": [document(*one) for one in found]})
        return
    rows = [
        (
            f"{motor.maker} {motor.designation}",
            f"{rounded(one.impulse)}/{rounded(one.record.impulse)}",
            f"{one.burn:.3g}/{one.record.burn:.3g}",
            f"{rounded(one.average)}/{rounded(one.record.average) if one.record.average else '-'}",
            f"{rounded(one.peak)}/{rounded(one.record.peak) if one.record.peak else '-'}",
            f"{one.largest:.1%}",
            used_curve(motor),
        )
        for motor, one in found
    ]
    headers = ("motor", "N s", "burn s", "avg N", "peak N", "off", "curve")
    print_table(headers, rows, numbers=headers[1:6])
    for motor, one in found:
        if one.why:
            complain(f"{motor.maker} {motor.designation}: the curve does not have the certified peak: {one.why}")
    changed = sum(bool(motor.curve) for motor, _ in found)
    beyond = sum(abs(one.deviation) > AGREEMENT for _, one in found)
    peaks = sum(bool(one.why) for _, one in found)
    complain(
        f"each figure of the curve / of the record; {counted(len(found), 'motor')}, {changed} with a curve that is not "
        f"the recorded one; off by more than {AGREEMENT:.0%} in impulse, burn time or average thrust: {beyond}; "
        f"in peak thrust: {peaks}"
    )


def print_own_corrections(json: bool) -> None:
    """Print the flyer's own corrections and their file, which is created if missing."""
    from fieldkit.motors.own_corrections import HEADER, OWN_FIELDS, correction_file, read_own_corrections

    folder = motor_folder()
    file = correction_file(folder)
    known_motors(always=True)  # reports the rows that cannot be used
    rows, _ = read_own_corrections(folder)
    if json:
        shown = [{"maker": one.maker, "motor": one.designation, "lot": one.lot, "date": one.date} for one in rows]
        more = [one.correction.json() for one in rows]
        print_json({"file": str(file), "corrections": [a | b for a, b in zip(shown, more, strict=True)]})
        return
    say(f"{file}")
    for one in rows:
        lot = f" lot {one.lot}" if one.lot else ""
        say(f"  {one.maker} {one.designation}{lot}{f' of {one.date}' if one.date else ''}: {one.text()}")
    if not rows:
        say(f"  one row per figure: {HEADER.strip()}")
        say_wrapped(f"  field: {', '.join(OWN_FIELDS)}", "    ")
        say_wrapped("  lot and date: for a row about one lot, named with the motor: F24-4W lot 0412", "    ")
