"""Answers offered by a form while typing: names from the ledger and the motor catalog, best match first."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import date, timedelta
from itertools import chain, islice

from fieldkit.errors import BadValue, UnknownMotor, nearest
from fieldkit.flight import TAGS
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue, Motor, is_cluster
from fieldkit.motors.names import parse, with_delay
from fieldkit.services.kits import kits as own_kits
from fieldkit.services.sites import sites

MAX_PICKS = 8
"""Maximum number of offered answers. [1]"""
NAME_QUESTIONS = ("rocket", "config", "site")
"""Questions whose answers are the user's names."""


@dataclass(frozen=True, slots=True)
class OfferedAnswer:
    """An answer that is offered, with its description."""

    text: str
    about: str = ""


Source = Callable[[str], Sequence[OfferedAnswer]]
"""The answers to offer for the text so far."""


@dataclass(frozen=True)
class Names:
    """The names that a ledger knows, by question, most recent first, and the motor catalog; `unflown` has where the
    names of other rockets are from: a design or a kit of the flyer."""

    known: Mapping[str, tuple[str, ...]]
    motors: Catalogue
    unflown: Mapping[str, str] = field(default_factory=dict)

    def sources(self) -> dict[str, Source]:
        """The picker for each question about names."""
        own: dict[str, Source] = {
            name: among([OfferedAnswer(one) for one in self.known[name]]) for name in NAME_QUESTIONS
        }
        own["rocket"] = among([OfferedAnswer(one, self.unflown.get(one, "")) for one in self.known["rocket"]])
        return own | {
            "motor": self._motors,
            "tags": among([OfferedAnswer(tag) for tag in TAGS]),
            "date_time": among(days()),
        }

    def _motors(self, typed: str) -> Sequence[OfferedAnswer]:
        """Motors flown before that contain the text, then those of the catalog, each with its delays; a delay in the
        text is offered before others."""
        flown = [OfferedAnswer(one, "flown before") for one in self.known["motor"] if _contains(one, typed)]
        if not typed.strip():
            return flown[:MAX_PICKS]
        sold: Iterable[OfferedAnswer] = chain.from_iterable(
            map(self.with_delays, self.motors.search(typed)[:MAX_PICKS])
        )
        asked = parse(typed).delay
        if asked is not None:
            sold = sorted(sold, key=lambda one: parse(one.text).delay != asked)
        return list(islice(chain(flown, sold), MAX_PICKS))

    def with_delays(self, motor: Motor) -> Iterable[OfferedAnswer]:
        """A motor once for each delay on sale, by names that mean it: `AeroTech F24W-4`, `Cesaroni 53F32-5`."""
        about = f"{motor.diameter * 1e3:.0f} mm, {motor.total_impulse:.0f} N s" + (
            "" if motor.available else ", retired"
        )
        name = f"{motor.maker} {motor.designation}"
        sold = [(f"{motor.maker} {with_delay(motor.designation, delay)}", delay) for delay in motor.delays]
        named = [text for text, delay in sold if self._means(text, motor, delay)]
        return [OfferedAnswer(text, about) for text in named or [name]]

    def _means(self, text: str, motor: Motor, delay: float) -> bool:
        """Whether a text names this motor with this delay [s]."""
        with suppress(UnknownMotor):
            found = self.motors.resolve(text)
            return found.motor is motor and found.delay == delay
        return False

    def doubt(self, name: str, text: object) -> str:
        """Why an answer may be a misspelling; empty for a known answer, and if there are none to compare."""
        if name == "motor":
            motor = str(text or "")
            return self.motor_trouble(motor) or self.motors.doubt(motor)
        if name not in ("rocket", "site") or not text or str(text) in self.known[name] or not self.known[name]:
            return ""
        near = nearest(str(text), self.known[name])
        return f"No {name} {text} yet; " + (f"did you mean {' or '.join(near)}?" if near else "this adds one")

    def motor_trouble(self, name: str) -> str:
        """Why a motor is unknown, empty if it is known or none is named."""
        return "" if not name or is_cluster(name) else self.motors.complaint(name) or ""


def names_of(ledger: Ledger, motors: Catalogue) -> Names:
    """The names that a ledger knows."""
    known = {name: tuple(ledger.names(name)) for name in (*NAME_QUESTIONS, "motor")}
    known["site"] = tuple(dict.fromkeys([*known["site"], *(site.name for site in sites(ledger))]))
    flown = known["rocket"]
    unflown = {one.name: "design" if one.designs else "planned" for one in ledger.rockets()}
    with suppress(BadValue):  # a damaged file is reported where the kits are listed
        unflown |= dict.fromkeys((kit.name for kit in own_kits()), "kit")
    known["rocket"] = tuple(dict.fromkeys([*known["rocket"], *unflown]))
    return Names(known, motors, {name: what for name, what in unflown.items() if name not in flown})


def among(picks: Sequence[OfferedAnswer]) -> Source:
    """The answers that match a text: first at their start, then in any part, then by its letters in order."""

    def found(typed: str) -> Sequence[OfferedAnswer]:
        text = typed.strip().casefold()
        tests = (_begins, _contains, _in_order)
        fitting = chain.from_iterable((pick for pick in picks if test(pick.text, text)) for test in tests)
        return list(islice(dict.fromkeys(fitting), MAX_PICKS))

    return found


def days() -> list[OfferedAnswer]:
    """Today, yesterday and the days before, in the format of typed dates."""
    now = date.today()
    before = [OfferedAnswer(f"{now - timedelta(days=n)}", f"{now - timedelta(days=n):%A}") for n in range(2, 7)]
    return [
        OfferedAnswer("today", f"{now:%A}, {now}"),
        OfferedAnswer("yesterday", f"{now - timedelta(days=1)}"),
        *before,
    ]


def _begins(name: str, typed: str) -> bool:
    return name.casefold().startswith(typed)


def _contains(name: str, typed: str) -> bool:
    return typed.strip().casefold() in name.casefold()


def _in_order(name: str, typed: str) -> bool:
    letters = iter(name.casefold())
    return all(letter in letters for letter in typed)
