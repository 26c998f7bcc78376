"""What is checked at the pad before a flight, in order: the rocket, what the safety checks leave open, the launch."""

from collections.abc import Iterator, Sequence

from fieldkit.flight import Flight
from fieldkit.messages import amount, message
from fieldkit.motors import Found
from fieldkit.planning.check import BY_EYE, SafetyCheck

CONTEST_MINUTES = 45
"""Length of the timer of contests, from the call of a team to its flight. The texts of the rules that were read do not
state it: ask at the event. [min]"""
ALTIMETER = "altimeter on and reset, its beeps heard or its zero seen"
LOOSE = "nose, fins and lugs or buttons hold; the rocket slides on the rail"
LAUNCH = (
    "safety key out while the igniter is connected; the clips are clean and do not touch",
    "people warned and at their distance, sky clear; a countdown of five seconds",
    "after a misfire: key out, and nobody near the rocket for 60 s",
)
"""Steps of every launch. Source: NAR Model Rocket Safety Code, ignition system, misfires and launch safety."""


def general_checklist() -> list[str]:
    """The steps at the pad of any flight."""
    recovery = "recovery undamaged and packed with flame-resistant wadding"
    return ["motor and delay as planned, retained", "weighed with its motor", recovery, ALTIMETER, LOOSE, *LAUNCH]


def pad_checklist(plan: Flight, found: Found, lines: Sequence[SafetyCheck]) -> list[str]:
    """The steps at the pad of a plan, in SI with their amounts: its own, the safety checks that failed or that only the
    flyer can make, and the launch."""
    return [message(one) for one in (*_rocket(plan, found), *_checks(lines), *LAUNCH)]


def _rocket(plan: Flight, found: Found) -> Iterator[str]:
    motor = found.motor
    delay = "" if plan.delay is None else f", delay {plan.delay:g} s"
    yield f"motor {plan.motor or motor.designation} of {motor.maker}{delay}, retained"
    if plan.dry_mass is not None:
        yield f"weighed with its motor: {amount(plan.dry_mass + motor.loaded_mass, 'g')} are planned"
    wanted = plan.columns.recovery
    yield f"{wanted.device} undamaged and packed with flame-resistant wadding"
    if wanted.dual:
        yield "altimeter armed for drogue and main, charges connected, its switch within reach"
    yield ALTIMETER
    yield LOOSE


def _checks(lines: Sequence[SafetyCheck]) -> Iterator[str]:
    yield from (f"{line.name} ({line.verdict}): {line.finding}" for line in lines if line.failed)
    yield from (f"{line.name}: {line.finding.removeprefix(BY_EYE)}" for line in lines if line.by_eye)
