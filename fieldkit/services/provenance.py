"""The inputs of a prediction, part by part, and which of them have changed.

A part is a few named texts in the units of the flight table, so that a stale prediction has a reason: `dry mass was 322
g, now 330 g`. Each flight used in the fit is saved as a digest of the fields that the model reads. The digest of a
prediction covers all parts.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldkit import __version__
from fieldkit.flight import BY_NAME, COLUMNS, CONDITIONS, LOGGED, Column, Flight
from fieldkit.flight.readout import render_sd
from fieldkit.flight.recovery import STABILITY
from fieldkit.flight.short_name import flight_label
from fieldkit.motors import Found, Motor
from fieldkit.quantities import significant, spelled
from fieldkit.rocket import Configuration
from fieldkit.units import unit

SourceDigests = Mapping[str, Mapping[str, str]]
"""The texts of each part, by name."""

OF_THE_PLAN = ("mass", "configuration", "motor", "conditions")
"""Parts set by the user, in which a flight can differ from its prediction."""
FROM_DESIGN, DRAG = ("dry_mass", "diameter"), "Cd"
"""What a plan may take from its rocket's design: columns, and the name of the coefficient."""
OF_THE_CLIMB = ("rail_direction", "wind_aloft", "wind_aloft_height", STABILITY)
"""Extra columns that change the simulated climb."""
USED_IN_FIT, FLOWN_ONLY = "+", "-"
"""Prefixes of a flight's digest: used in the fit, or only counted as flown."""


def is_made_from(saved: object) -> bool:
    """Whether a saved value has the parts of a prediction's inputs: any program may have written it."""
    if not isinstance(saved, Mapping) or not all(map(is_texts, saved.values())):
        return False
    if not all(part in saved for part in (*OF_THE_PLAN, "model", "flights")):
        return False
    return "name" in saved["model"] and all(saved["flights"].values())


def is_texts(saved: object) -> bool:
    """Whether a saved value is a table of texts by name."""
    return isinstance(saved, Mapping) and all(isinstance(text, str) for text in saved.values())


@dataclass(frozen=True, slots=True)
class InputChange:
    """A changed input: its name and its texts before and after, or in one phrase what happened to it."""

    name: str
    old: str = ""
    new: str = ""
    of: str = ""

    def words(self, system: str = "") -> str:
        """`dry mass was 322 g, now 330 g`, in the units of a system, by default in those of the flight table."""
        if self.old == self.new:
            return self.name
        if self.name == "thrust":
            return "the motor's thrust curve changed"
        column = next((column for column in COLUMNS if column.header == self.name), None)
        before, after = (_shown(text, column, system) for text in (self.old, self.new))
        return f"{self.of}{column.title.lower() if column else self.name} was {before}, now {after}"


def _shown(text: str, column: Column | None, system: str) -> str:
    """A text of a part with its unit, in the units of a system if it is given."""
    if not text:
        return "not given"
    if column is None:
        return text
    if not system:
        return f"{text} {spelled(column.unit)}"
    try:
        return significant(column, unit(column.quantity, column.unit).to_si(float(text)), system)
    except ValueError:  # saved by another program
        return text


def plan_parts(plan: Flight, found: Found) -> dict[str, dict[str, str]]:
    """The parts that the user sets, for a plan completed from earlier flights."""
    delay = plan.delay if plan.delay is not None else found.delay  # as simulated
    climb = _of_the_climb(plan)
    return {
        "mass": _columns(plan, ["dry_mass"]),
        "configuration": {"config": plan.config, **_columns(plan, ["diameter"])},
        "motor": {
            "motor": f"{found.motor.maker} {found.motor.designation}",
            "delay_s": "" if delay is None else f"{delay:g}",
            "thrust": motor_digest(found.motor),
        },
        "conditions": _columns(plan, [column.name for column in CONDITIONS]),
        **({"climb": climb} if climb else {}),
    }


def _of_the_climb(flight: Flight) -> dict[str, str]:
    """The extra columns that the simulation of a flight reads, as recorded; most flights have none."""
    return {header: text.strip() for header, text in flight.columns.as_recorded(OF_THE_CLIMB).items()}


def model_parts(history: Sequence[Flight], name: str, version: int | None) -> dict[str, dict[str, str]]:
    """The parts from the model: its version (None for one requested by name) and its flights."""
    asked = {"name": name} if version is None else {"name": name, "version": str(version)}
    return {
        "model": {**asked, "fieldkit": __version__},
        "flights": {flight.flight_id: flight_digest(flight) for flight in history if flight.readouts()},
    }


def design_parts(start: Configuration | None, plan: Flight) -> dict[str, dict[str, str]]:
    """The part from the rocket's design: its Cd, and the mass and diameter that the plan took from it."""
    known = _design(start)
    taken = {header: text for header, text in _columns(plan, FROM_DESIGN).items() if text and text == known.get(header)}
    return {"design": {DRAG: known.get(DRAG, ""), **taken}}


def design_changes(made: SourceDigests, start: Configuration | None) -> Iterator[InputChange]:
    """What changed in the rocket's design, one by one."""
    now = _design(start)
    for name, old in made.get("design", {}).items():
        if old != now.get(name, ""):
            yield InputChange(name, old, now.get(name, ""), of="the design's ")


def _design(start: Configuration | None) -> dict[str, str]:
    if start is None:
        return {}
    drag = "" if start.cd is None else f"{start.cd:.6g}"
    return {DRAG: drag, **_columns(Flight(dry_mass=start.dry_mass, diameter=start.diameter), FROM_DESIGN)}


def digest(parts: SourceDigests) -> str:
    """SHA-256 of all inputs of a prediction, in hex."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def flight_digest(flight: Flight) -> str:
    """Eight hex digits from the fields of a flight that the model reads, after a mark for its use in the fit."""
    when = flight.date_time.isoformat() if flight.date_time else ""
    read = [flight.config, flight.motor, flight.site, when, *_columns(flight, BY_NAME).values()]
    read += [f"{c.header} {c.render(value)}" for c in LOGGED if (value := flight.number(c.name)) is not None]
    read += [f"{BY_NAME[name].sd_header} {render_sd(name, sd)}" for name, sd in sorted(flight.sd.items())]
    read += [f"{header} {text}" for header, text in _of_the_climb(flight).items()]
    return (USED_IN_FIT if flight.clean else FLOWN_ONLY) + _short(json.dumps(read))


def motor_digest(motor: Motor) -> str:
    """Eight hex digits from a motor's thrust curve and masses, because a user's file may change under the same name."""
    numbers = [*motor.time.tolist(), *motor.thrust.tolist(), motor.propellant_mass, motor.casing_mass]
    return _short(json.dumps([f"{number:.6g}" for number in numbers]))


def plan_changes(made: SourceDigests, now: SourceDigests, *, flown: bool) -> Iterator[InputChange]:
    """What the user changed in a plan, one by one.

    For a flown flight only values that both have are compared: a temperature that the forecast lacked is not a change.
    """
    for part in OF_THE_PLAN:
        for name, new in now[part].items():
            old = made[part].get(name, "")
            if old == new or (flown and not (old and new)):
                continue
            yield InputChange(name, old, new)


def model_changes(made: SourceDigests, now: SourceDigests) -> Iterator[InputChange]:
    """What changed in the model and its flights, one by one."""
    return map(InputChange, _model_phrases(made, now))


def _model_phrases(made: SourceDigests, now: SourceDigests) -> Iterator[str]:
    for name, old in made["model"].items():
        new = now["model"].get(name, "")
        if name == "version" and old != new:
            yield f"{_version(old)} replaced by {_version(new)}"
        elif name == "fieldkit" and new and old != new:
            yield f"made by fieldkit {old}, now {new}"
    before, after = made["flights"], now["flights"]
    for one, old in before.items():
        if one not in after:
            yield f"{flight_label(one)} was removed"
        elif after[one][0] != old[0]:
            yield f"{flight_label(one)} {'is used in the fit again' if after[one][0] == USED_IN_FIT else 'is tagged'}"
        elif after[one] != old:
            yield f"{flight_label(one)} was edited"
    if new_ones := [one for one in after if one not in before]:
        several = f"flights {', '.join(new_ones[:4])}{' and more' if len(new_ones) > 4 else ''}"
        yield f"{several if len(new_ones) > 1 else flight_label(new_ones[0])} added since"


def _version(number: str) -> str:
    return "no correction" if number == "0" else f"model version {number}"


def _columns(flight: Flight, names: Sequence[str] | Mapping[str, object]) -> dict[str, str]:
    """Numbers of a flight as texts under their headers, empty if not recorded."""
    return {column.header: _text(column, flight.number(column.name)) for column in COLUMNS if column.name in names}


def _text(column: Column, value: float | None) -> str:
    if value is None:
        return ""
    return f"{unit(column.quantity, column.unit).from_si(value):.6g}"


def _short(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]
