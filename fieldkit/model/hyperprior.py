"""The hyperprior: how far rockets, motors, days and single flights differ, and what a device makes of each readout.

Every quantity of the model (drag, thrust, mass, burn, delay, and each readout's own discrepancy) is a mean plus random
effects: of the flyer's whole fleet, the rocket, its configuration, the motor type, the rocket on that motor, the day
and the single flight. All but delay and the time to ejection are logarithms of ratios [1]; these two are in the units
named below. This module is the one place where their standard deviations are stated.

`learned` is the card that `fieldkit learn` wrote: marginal likelihood of real flights. `certified` is the same model
given that motors, masses and devices are what their papers say, as the search for effects needs it: there an effect and
not the plain model has to stand for a motor that is off its certificate.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fieldkit.errors import DamagedModel
from fieldkit.files import read_own
from fieldkit.model.scale import Scale, scale_pairs
from fieldkit.paths import hyperprior_file
from fieldkit.shapes import Array, Float

FROM_LOGS = ("coast_drag", "burn_impulse")
"""Readouts that only the samples of a log show."""
READOUTS = ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject", *FROM_LOGS)
"""Readouts that the model compares. Average acceleration is top speed over burn time and adds no information; the
rest belongs to the descent."""
QUANTITIES = ("drag", "thrust", "mass", "stretch", "delay", *READOUTS)
"""What random effects act on: `stretch` is the burn, the delay is by ratio, `apogee_to_eject` in seconds."""
FROM_DEVICES = ("top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject")
"""Readouts that each device shows by its own rule, and that the samples of a sensor show without one."""
LEVELS = ("fleet", "rocket", "config", "motor", "rocket_motor", "day", "flight", "logged")
"""Groups of flights that share a random effect, widest first; `logged` is a rocket's readouts that were measured in the
samples of a sensor, which take no part in the bias of a device."""
CARD = "hyperprior.json"

Kind = Literal["learned", "certified"]


@dataclass(frozen=True, slots=True, eq=False)
class Hyperprior:
    """Means and standard deviations of every random effect, and the noise of each readout.

    `means` are by quantity; `drag` is that of log Cd. `mean_sds` is how well each is known: few flyers, of one device,
    show it. `sds` are by `quantity.level`; one that is missing or zero is an effect the model does not have. `fixed` is
    the noise of a readout in its unit (m, m/s, s, m/s^2, s, s, 1/m, m/s), `ratio` that which grows with it [1].
    `unknown_area` is the standard deviation of the log frontal area of a rocket whose diameter was not recorded.
    `opening` is mean and standard deviation of the parachute's opening time [s]. `scatter` scales the random effects of
    single flights, `reading` the noise of every readout but the apogee. `tail` is the degrees of freedom of the Student
    t that single flights and readings follow.
    """

    kind: Kind
    means: Mapping[str, float]
    sds: Mapping[str, float]
    fixed: tuple[float, ...]
    ratio: tuple[float, ...]
    unknown_area: float
    scatter: Scale
    reading: Scale
    opening: tuple[float, float] = (0.6, 0.4)
    tail: float = 4.0
    mean_sds: Mapping[str, float] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)

    def sd(self, quantity: str, level: str) -> float:
        """Standard deviation of one random effect, 0 for one that the model does not have."""
        return self.sds.get(f"{quantity}.{level}", 0.0)

    def mean(self, quantity: str) -> float:
        """Mean of a quantity over all flyers."""
        return self.means.get(quantity, 0.0)

    def fleet_sd(self, quantity: str) -> float:
        """How far a flyer's fleet may lie from the mean: flyers differ, and the mean itself is known so well. [1], [s]

        0 for a quantity in which flyers do not differ.
        """
        between = self.sd(quantity, "fleet")
        return float(np.hypot(between, self.mean_sds.get(quantity, 0.0))) if between else 0.0

    def with_sds(self, **sds: float) -> "Hyperprior":
        """The same with other standard deviations, `quantity__level` for `quantity.level`."""
        return replace(self, sds={**self.sds, **{name.replace("__", "."): sd for name, sd in sds.items()}})

    def refined(self) -> "Hyperprior":
        """The same with finer grids of both scales: what a posterior is reported with, a fit having found its place."""
        return replace(self, scatter=self.scatter.refined(), reading=self.reading.refined())

    def scales(self) -> tuple[Float[Array, "scale"], Float[Array, "scale"], Float[Array, "scale"]]:
        """Scatter scale, reading scale and normalized log prior of every pair on the grid."""
        return scale_pairs(self.scatter, self.reading)

    def json(self) -> dict[str, Any]:
        """The card, as `learned` reads it."""
        return {**self.about, **self.model_json()}

    def model_json(self) -> dict[str, Any]:
        """The same without what it was learned from."""
        return {
            "means": dict(self.means),
            "mean_sds": dict(self.mean_sds),
            "sds": dict(self.sds),
            "noise": {
                name: {"fixed": fixed, "ratio": ratio}
                for name, fixed, ratio in zip(READOUTS, self.fixed, self.ratio, strict=True)
            },
            "unknown_area": self.unknown_area,
            "scatter": {"median": self.scatter.median, "log_sd": self.scatter.log_sd},
            "reading": {"median": self.reading.median, "log_sd": self.reading.log_sd},
            "opening_s": list(self.opening),
            "tail": self.tail,
        }


SCATTER_GRID = tuple(float(x) for x in np.round(np.geomspace(0.25, 4.0, 7), 4))
READING_GRID = tuple(float(x) for x in np.round(np.geomspace(0.2, 3.0, 5), 4))
"""What a fit is followed on; the posterior it ends with is on grids twice as fine."""

CERTIFIED_PRIOR = Hyperprior(
    kind="certified",
    means=MappingProxyType({"drag": float(np.log(0.6))}),
    sds=MappingProxyType(
        {
            "drag.rocket": 0.35,
            "drag.config": 0.0105,
            "drag.flight": 0.03,
            "thrust.rocket": 0.007,
            "thrust.motor": 0.007,
            "thrust.flight": 0.025,
            "mass.rocket": 0.02,
            "stretch.motor": 0.014,
            "stretch.flight": 0.02,
            "delay.motor": 0.08,
            "delay.flight": 0.08,
            "tilt.flight": 1.0,
            "top_speed.rocket": 0.01,
            "burn_time.rocket": 0.05,
            "peak_accel.rocket": 0.06,
            "coast_to_apogee.rocket": 0.01,
            "apogee_to_eject.rocket": 0.1,
            "coast_drag.rocket": 0.02,
            "burn_impulse.rocket": 0.01,
        }
    ),
    fixed=(1.5, 0.7, 0.07, 0.5, 0.08, 0.15, 0.0, 0.0),
    ratio=(0.005, 0.015, 0.02, 0.04, 0.01, 0.0, 0.05, 0.03),
    unknown_area=0.45,
    scatter=Scale((0.5, 1.0, 1.6, 2.5, 4.0, 6.5), 2.0, 0.7),
    reading=Scale((0.7, 1.2, 2.0), 1.0, 0.4),
)
"""Motors within their certificate (2 to 3 % within a lot), Cd from 0.35 to 1.1 (Mandell et al., 1973; Hoerner, 1965),
masses as weighed, devices as specified. `tilt` is in units of a launch angle of 5 degrees, squared."""


START = Hyperprior(
    kind="learned",
    means=MappingProxyType({"drag": float(np.log(0.6)), "apogee": 0.0}),
    sds=MappingProxyType(
        {
            "drag.fleet": 0.15,
            "drag.rocket": 0.3,
            "drag.config": 0.05,
            "drag.flight": 0.03,
            "thrust.fleet": 0.02,
            "thrust.motor": 0.05,
            "thrust.flight": 0.025,
            "mass.fleet": 0.05,
            "mass.rocket": 0.05,
            "stretch.motor": 0.05,
            "stretch.flight": 0.03,
            "delay.motor": 0.1,
            "delay.flight": 0.1,
            "apogee.fleet": 0.05,
            "apogee.rocket": 0.05,
            "apogee.rocket_motor": 0.05,
            "apogee.day": 0.02,
            "apogee.flight": 0.06,
            "top_speed.fleet": 0.05,
            "top_speed.rocket": 0.03,
            "burn_time.fleet": 0.05,
            "burn_time.rocket": 0.03,
            "peak_accel.fleet": 0.1,
            "peak_accel.rocket": 0.1,
            "coast_to_apogee.fleet": 0.05,
            "coast_to_apogee.rocket": 0.03,
            "apogee_to_eject.fleet": 0.1,
            "apogee_to_eject.rocket": 0.1,
            "top_speed.logged": 0.03,
            "burn_time.logged": 0.03,
            "peak_accel.logged": 0.1,
            "coast_to_apogee.logged": 0.03,
            "apogee_to_eject.logged": 0.1,
            "coast_drag.rocket": 0.08,
            "burn_impulse.rocket": 0.05,
        }
    ),
    fixed=(1.0, 0.3, 0.05, 0.5, 0.05, 0.5, 0.0, 0.0),
    ratio=(0.005, 0.05, 0.05, 0.15, 0.05, 0.0, 0.05, 0.03),
    unknown_area=0.2,
    scatter=Scale(SCATTER_GRID, 1.0, 0.7),
    reading=Scale(READING_GRID, 1.0, 0.7),
)
"""What the fit starts from, and stays near if flights do not determine it: round figures from before any real flight
was looked at. Cd as in `CERTIFIED_PRIOR`; motor types within 5 % of their certificate (the tests that certify them
differ by that: NFPA 1125 allows 10 %), burn and delay within 5 and 10 %; masses 5 %, for altimeter, recovery and
wadding are not always weighed; a device 5 % off in what all of its kind show; single flights 6 %. Devices are off
about the truth, for each maker means to show it: the open flights come from one device, and one does not distinguish a
mean over devices from how far they differ. How far devices
differ from each other in noise (`reading`) stays a judgment for the same reason. Readouts measured in
samples differ from the simulated ones as those of one rocket do, and have no device's rule in them. What a log shows of
drag and impulse has the standard deviation that analysis gives it (`ratio` is for one that was lost); beside it two
altimeters of one open flight differ by 13 and 9 %, more than climbing 15 degrees from vertical explains (1/cos 15 =
1.035 of the drag, cos 15 = 0.97 of the impulse)."""

_LOGGED = {key: sd for key, sd in START.sds.items() if key.endswith(".logged")}
"""What a card of an older fieldkit lacks: no open flight has a readout of both kinds, so these stay judgments."""


def certified() -> Hyperprior:
    """The hyperprior given that motors, masses and devices are what their papers say."""
    return CERTIFIED_PRIOR


@cache
def learned() -> Hyperprior:
    """The hyperprior in use: the flyer's own from `fieldkit learn --keep`, else the one that ships with fieldkit.

    Raises DamagedModel.
    """
    own = hyperprior_file()
    if own.exists():
        try:
            return read_card(read_own(own), str(own))
        except (OSError, UnicodeDecodeError) as error:
            raise DamagedModel(f"{own}: cannot be read ({error}), expected a hyperprior card") from error
    return read_card(files("fieldkit.data").joinpath(CARD).read_text("utf-8"), CARD)


def _noise_of(card: Mapping[str, Any], readout: str) -> Mapping[str, float]:
    """The noise of a readout; of those from logs, which a card of an older fieldkit lacks, as in `START`."""
    place = READOUTS.index(readout)
    start = {"fixed": START.fixed[place], "ratio": START.ratio[place]}
    noise: Mapping[str, float] = card["noise"].get(readout, start) if readout in FROM_LOGS else card["noise"][readout]
    return noise


def read_card(text: str, name: str) -> Hyperprior:
    """A hyperprior from its card. Raises DamagedModel, naming the card, for one that cannot be."""
    try:
        card = json.loads(text)
        noise = [_noise_of(card, readout) for readout in READOUTS]
        found = Hyperprior(
            kind="learned",
            means=MappingProxyType({key: float(x) for key, x in card["means"].items()}),
            mean_sds=MappingProxyType({key: float(x) for key, x in card.get("mean_sds", {}).items()}),
            sds=MappingProxyType(_LOGGED | {key: float(x) for key, x in card["sds"].items()}),
            fixed=tuple(float(one["fixed"]) for one in noise),
            ratio=tuple(float(one["ratio"]) for one in noise),
            unknown_area=float(card["unknown_area"]),
            scatter=Scale(SCATTER_GRID, float(card["scatter"]["median"]), float(card["scatter"]["log_sd"])),
            reading=Scale(READING_GRID, float(card["reading"]["median"]), float(card["reading"]["log_sd"])),
            opening=(float(card["opening_s"][0]), float(card["opening_s"][1])),
            tail=float(card["tail"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
        raise DamagedModel(f"{name}: found {error!r}, expected a hyperprior as `fieldkit learn` writes it") from error
    positive = [
        *found.sds.values(),
        *found.mean_sds.values(),
        *found.fixed,
        *found.ratio,
        found.unknown_area,
        found.tail,
    ]
    values = [*found.means.values(), *positive]
    unknown = [key for key in found.sds if not _known(key)]
    if unknown or not np.isfinite(values).all() or min(positive) < 0:
        wrong = f"the unknown effect {unknown[0]!r}" if unknown else "a figure that is negative or not finite"
        raise DamagedModel(f"{name}: found {wrong}, expected standard deviations of {', '.join(QUANTITIES)}")
    about = {key: value for key, value in card.items() if key not in found.json()}
    return replace(found, about=MappingProxyType(about))


def _known(key: str) -> bool:
    quantity, _, level = key.partition(".")
    return quantity in (*QUANTITIES, "tilt") and level in LEVELS
