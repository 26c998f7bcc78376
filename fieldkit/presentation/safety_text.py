"""The safety checks of a plan as lines: folded next to its forecast, or every one in full."""

from collections.abc import Iterator, Sequence

from fieldkit.planning.check import ADVICE_NOTE, MARKS, SafetyCheck, worst_first


def every_check(lines: Sequence[SafetyCheck], system: str = "SI") -> Iterator[str]:
    """Every check in full in a system of units, those that failed first, with rules and sources; then who decides."""
    yield from (line.words(system) for line in worst_first(lines))
    yield ADVICE_NOTE


def failed_checks(lines: Sequence[SafetyCheck], system: str = "SI") -> Iterator[str]:
    """What each failed check found, the worst first, without rules and sources."""
    yield from (line.words(system, source=False, rule=False) for line in worst_first(lines) if line.failed)


def other_checks(lines: Sequence[SafetyCheck]) -> Iterator[str]:
    """How many checks lack data, are the flyer's to make, or passed: `? 12 not given, 6 to check yourself`,
    `✓ 5 passed`."""
    unknown = [line for line in lines if line.verdict == "unknown"]
    by_eye = sum(line.by_eye for line in unknown)
    counts = ((len(unknown) - by_eye, "not given"), (by_eye, "to check yourself"))
    if given := [f"{count} {word}" for count, word in counts if count]:
        yield f"{MARKS['unknown']} {', '.join(given)}"
    if passed := sum(line.verdict == "ok" for line in lines):
        yield f"{MARKS['ok']} {passed} passed"
