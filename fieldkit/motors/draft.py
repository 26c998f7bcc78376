"""A motor as read from a file, validated and converted to a `Motor`: shared by `.eng` and `.rse`."""

import math
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from dataclasses import dataclass, field

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.motors.motor import BURN_THRUST_FRACTION, PLUGGED_DELAY, Motor, impulse, impulse_class, knots, normalised
from fieldkit.motors.names import maker_of, parse
from fieldkit.quantities import counted

PER_IMPULSE = "by 1 to 1.7% for each percent of the impulse"
"""How much missing impulse lowers an apogee: `fieldkit simulate` of F24-4W (322 g, 66 mm), A8-3 (40 g, 25 mm) and C6-5
(60 g, 25 mm), with a Cd of 0.6 and a thrust factor of 0.9."""
_EXHAUST = (20.0, 200_000.0)
"""Range of impulse per propellant mass; outside it, the mass must be in another unit. [m/s]"""
_MAX_VALUE = 1e7
"""Upper limit of any length, mass, time or thrust in a motor file, in any unit."""
MAX_MOTORS = 10_000
"""Maximum number of motors in one file: only a few thousand have ever been certified. [1]"""
_ROCKSIM_PLUGGED = 1000.0
"""The delay with which RockSim marks a motor without an ejection charge. [s]"""


@dataclass(frozen=True, slots=True)
class FileLine:
    """A line of a file, which is the origin of a draft's values."""

    source: str
    row: int

    def __str__(self) -> str:
        return f"{self.source}, row {self.row}"

    def damaged(self, found: str, column: str | None = None) -> DamagedLog:
        """The error that names this line."""
        return DamagedLog(found, row=self.row, column=column, source=self.source)

    def number(self, text: str, column: str, unit: str) -> float:
        """Parse a finite number of plausible size, in the unit of the file. Raises DamagedLog for other texts."""
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not abs(value) <= _MAX_VALUE:
            raise self.damaged(f"found {text!r}, expected a number ({unit})", column)
        return value

    def above(self, text: str, column: str, unit: str, least: float) -> float:
        """Parse a number above a bound, in the unit of the file. Raises DamagedLog for other texts."""
        value = self.number(text, column, unit)
        if value <= least:
            raise self.damaged(f"found {text!r}, expected more than {least:g} {unit}", column)
        return value


@dataclass(slots=True)
class MotorDraft:
    """The header of a motor in SI units, and the samples read so far, each with its line in the file; `failed` if one
    of them is damaged."""

    place: FileLine
    maker: str
    designation: str
    kind: str
    diameter: float
    length: float
    delays: tuple[float, ...]
    propellant_mass: float
    loaded_mass: float
    samples: list[tuple[FileLine, float, float]] = field(default_factory=list)
    failed: bool = False

    def add(self, place: FileLine, time: float, thrust: float) -> None:
        """Add a sample [s, N]. Raises DamagedLog if time is negative or goes backward."""
        if self.samples and time < self.samples[-1][1]:
            raise place.damaged(f"found the time {time:g} after {self.samples[-1][1]:g}, expected times that increase")
        if time < 0:
            raise _negative(place, time, thrust)
        self.samples.append((place, time, thrust))

    def motor(self) -> Motor:
        """The motor. Raises DamagedLog for a curve that is truncated, negative or empty, and for impossible masses."""
        if not self.samples:
            raise self.place.damaged(f"found no thrust for {self.designation}, expected samples below its header")
        last, _, end = self.samples[-1]
        noise = BURN_THRUST_FRACTION * max(thrust for _, _, thrust in self.samples)
        curve, remarks = self._without_noise(noise)
        if end > noise:
            curve.append((curve[-1][0], 0.0))
            remarks.append(
                f"{last}: the curve ends at {end:g} N, taken to fall to 0 there: the file may be cut short, "
                f"and apogees too low, {PER_IMPULSE}"
            )
        try:
            time, thrust = knots(*zip(*curve, strict=True))
        except BadValue as error:
            raise last.damaged(str(error)) from None
        total = impulse(time, thrust)
        self._check_masses(total)
        name = parse(self.designation).core
        if end > noise and total <= _least_impulse(name):
            found = f"found a curve of {total:.3g} N s that ends at {end:g} N, expected 0: the file is cut short"
            raise last.damaged(found)
        thrust = normalised(time, thrust, total)
        time.setflags(write=False)
        thrust.setflags(write=False)
        return Motor(
            maker=maker_of(self.maker),
            name=name or self.designation,
            designation=self.designation,
            impulse_class=name.rstrip("0123456789.") or impulse_class(total),
            kind=self.kind,
            diameter=self.diameter,
            length=self.length,
            total_impulse=total,
            propellant_mass=self.propellant_mass,
            casing_mass=self.loaded_mass - self.propellant_mass,
            delays=self.delays,
            available=True,
            time=time,
            thrust=thrust,
            source=self.place.source,
            remarks=tuple(remarks),
        )

    def _without_noise(self, noise: float) -> tuple[list[tuple[float, float]], list[str]]:
        """The samples [s, N], with 0 for negative thrust that is noise of a test stand [N], and a remark on it.

        Raises DamagedLog for thrust further below 0.
        """
        below = [(place, time, thrust) for place, time, thrust in self.samples if thrust < 0]
        for place, time, thrust in below:
            if thrust < -noise:
                raise _negative(place, time, thrust)
        lowest = min((thrust for _, _, thrust in below), default=0.0)
        remarks = [f"{below[0][0]}: {counted(len(below), 'thrust')} down to {lowest:g} N taken as 0"] if below else []
        return [(time, max(thrust, 0.0)) for _, time, thrust in self.samples], remarks

    def _check_masses(self, total: float) -> None:
        propellant, loaded = self.propellant_mass * 1e3, self.loaded_mass * 1e3
        if loaded <= propellant:
            raise self.place.damaged(
                f"found {propellant:g} g of propellant in a motor of {loaded:g} g, expected it to weigh more"
            )
        if not _EXHAUST[0] < total / self.propellant_mass < _EXHAUST[1]:
            raise self.place.damaged(
                f"found {self.propellant_mass:g} kg of propellant for {total:g} N s, "
                "expected about 0.5 g per N s: masses are kilograms in .eng and grams in .rse"
            )


def _negative(place: FileLine, time: float, thrust: float) -> DamagedLog:
    return place.damaged(f"found {time:g} s, {thrust:g} N, expected neither to be negative")


def _least_impulse(name: str) -> float:
    """The total impulse above which a motor of this name begins its class; 0 if the name has none. [N s]"""
    letter = re.match(r"([A-Z])\d", name)
    return 1.25 * 2.0 ** (ord(letter[1]) - ord("A")) if letter else 0.0


def delays(text: str, place: FileLine) -> tuple[float, ...]:
    """Parse delays as written in files: `4-7-10`, `4,7,P`, `6A`; words such as S, M and L are ignored. [s]

    Raises DamagedLog for other texts.
    """
    found = []
    for word in re.split(r"[-,;/\s]+", text.strip().upper()):
        number = re.fullmatch(r"(\d+(?:\.\d+)?)[A-Z]?", word)
        if word in ("P", "PLUGGED"):
            found.append(PLUGGED_DELAY)
        elif number:
            found.append(PLUGGED_DELAY if float(number[1]) >= _ROCKSIM_PLUGGED else float(number[1]))
        elif not re.fullmatch(r"[A-Z*]*", word):
            raise place.damaged(f"found {word!r}, expected delays such as 4-7-10 or P", "delays")
    return tuple(found)


def finished(drafts: list[MotorDraft], errors: list[DamagedLog]) -> tuple[list[Motor], list[DamagedLog]]:
    """The motors of a file, and its errors: those found while it was read, and those of motors that are impossible. A
    damaged motor does not affect the others; an error within its rows is the one reported."""
    motors: list[Motor] = []
    damaged = list(errors)
    for draft in drafts:
        if draft.failed:
            continue
        try:
            motors.append(draft.motor())
        except DamagedLog as error:
            damaged.append(error)
    return motors, damaged


def add_draft(drafts: list[MotorDraft], draft: MotorDraft) -> None:
    """Add a motor to those of a file. Raises DamagedLog if there are too many."""
    if len(drafts) >= MAX_MOTORS:
        raise draft.place.damaged(f"found more than {MAX_MOTORS} motors, the limit of one file")
    drafts.append(draft)


def decoded(data: bytes) -> str:
    """Decode a text file: UTF-8 or UTF-16, with or without byte order mark, else Windows-1252.

    The NULs or the 0x1A with which some systems end a file, and whatever is below them, are left out.
    """
    wide = wide_encoding(data)
    for encoding in (wide,) if wide else ("utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError:
            text = data.decode(encoding, "replace")
    return re.split("[\0\x1a]", text.removeprefix("\ufeff"), maxsplit=1)[0]


def wide_encoding(data: bytes) -> str:
    """The encoding of a text in UTF-16, with or without byte order mark; empty for others."""
    if data.startswith(BOM_UTF16_LE) or re.match(rb"[^\0]\0[^\0]\0", data):
        return "utf-16-le"
    return "utf-16-be" if data.startswith(BOM_UTF16_BE) or re.match(rb"\0[^\0]\0[^\0]", data) else ""
