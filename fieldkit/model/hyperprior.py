"""The hyperprior: how much rockets, motors, days and single flights vary, and how each device biases each readout.

Every quantity of the model (drag, thrust, mass, burn, delay, and a discrepancy for each readout) is a mean plus random
effects for the flyer's fleet, the rocket, its configuration, the motor type and its lot, the rocket on that motor, the
day and the single flight: log ratios [1] or times to ejection [s]. Their deviations are stated here and nowhere else.

`learned` is the card that `fieldkit learn` wrote by maximizing the marginal likelihood of real flights.
`certified_prior` is the same model if motors, masses and devices match their documents. The search for effects uses it,
so that an effect, and not the plain model, explains a motor that differs from its certificate.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fieldkit.errors import DamagedModel
from fieldkit.files import read_own
from fieldkit.flight.recovery import UNCERTAIN_WEATHER
from fieldkit.model.scale import Scale, scale_grid
from fieldkit.paths import hyperprior_file
from fieldkit.shapes import Array, Float

FROM_LOGS = ("coast_drag", "burn_impulse")
"""Readouts that only the samples of a log provide."""
READOUTS = ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject", *FROM_LOGS)
"""Readouts that the model compares: without average acceleration, which they determine, and those of the descent."""
QUANTITIES = ("drag", "thrust", "mass", "stretch", "delay", *READOUTS)
"""Quantities with random effects. `stretch` scales the burn time, the delay is a log ratio, ejection is in seconds."""
FROM_DEVICES = ("top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject")
"""Readouts that each device defines in its own way; readouts measured in a sensor's samples have no such rule."""
LEVELS = ("fleet", "drift", "rocket", "config", "motor", "lot", "rocket_motor", "day", "flight", "logged", "ports")
"""Groups of flights that share a random effect, widest first. `logged` are a rocket's readouts measured in samples,
without the bias of a device; `ports` those measured in samples of a barometer, which static ports bias."""
CARD = "hyperprior.json"
DESIGN_DRAG = 0.2
"""Start of `Hyperprior.design_drag`, an expert judgment: paint, lugs and gaps are rarely as drawn. [1]"""
Kind = Literal["learned", "certified"]


@dataclass(frozen=True, slots=True, eq=False)
class Hyperprior:
    """Mean and standard deviation of every random effect, and the noise of each readout.

    `means` are by quantity; `drag` is the mean log Cd. `mean_sds` is the uncertainty of each mean, which comes from few
    flyers with one device. `sds` are by `quantity.level`; a missing or zero entry means that the model lacks that
    effect. `fixed` is the constant noise of a readout in its unit (m, m/s, s, m/s^2, s, s, 1/m, m/s), and `ratio` is
    the noise proportional to it [1]. `unknown_area` is the standard deviation of the log frontal area of a rocket whose
    diameter is not recorded. `opening` is the mean and standard deviation of the parachute's opening time [s].
    `scatter` scales the random effects of single flights, and `reading` the noise of every readout except the apogee.
    With `motors`, those in the quantities of `scaled_by_motors` are scaled by it instead. `documents` scales how far
    motors, masses and devices are from their documents (`fieldkit.model.documents`).
    `tail` is the degrees of freedom of the Student t distribution of single flights and readings. `design_drag` is the
    standard deviation of the log Cd of a rocket with a design, around the Cd of the design. `high_power` scales the
    random effects of mass, thrust and apogee of such a rocket on high-power motors.
    """

    kind: Kind
    means: Mapping[str, float]
    sds: Mapping[str, float]
    fixed: tuple[float, ...]
    ratio: tuple[float, ...]
    unknown_area: float
    scatter: Scale
    reading: Scale
    motors: Scale | None = None
    documents: Scale | None = None
    scaled_by_motors: tuple[str, ...] = ("thrust", "drag", "stretch", "delay")
    opening: tuple[float, float] = (0.6, 0.4)
    tail: float = 4.0
    mean_sds: Mapping[str, float] = field(default_factory=dict)
    design_drag: float = DESIGN_DRAG
    high_power: float = 1.0
    about: Mapping[str, Any] = field(default_factory=dict)

    def sd(self, quantity: str, level: str) -> float:
        """Standard deviation of one random effect; 0 if the model lacks it. [1] or [s]"""
        return self.sds.get(f"{quantity}.{level}", 0.0)

    def mean(self, quantity: str) -> float:
        """Mean of a quantity over all flyers. [1] or [s]"""
        return self.means.get(quantity, 0.0)

    def fleet_sd(self, quantity: str) -> float:
        """Standard deviation of a flyer's fleet mean: variation among flyers plus the uncertainty of the overall mean.

        0 for a quantity that does not vary among flyers. [1] or [s]
        """
        between = self.sd(quantity, "fleet")
        return float(np.hypot(between, self.mean_sds.get(quantity, 0.0))) if between else 0.0

    def with_sds(self, **sds: float) -> "Hyperprior":
        """A copy with other standard deviations; a keyword `quantity__level` stands for `quantity.level`."""
        return replace(self, sds={**self.sds, **{name.replace("__", "."): sd for name, sd in sds.items()}})

    def refined(self) -> "Hyperprior":
        """A copy with finer grids of `scatter` and `reading`, used to report a posterior once a fit has converged."""
        return replace(self, scatter=self.scatter.refined(), reading=self.reading.refined())

    def with_refined_documents(self) -> "Hyperprior":
        """A copy in which the scale of documents runs over its prior."""
        return replace(self, documents=self.documents and self.documents.refined())

    def scales(self) -> tuple[Float[Array, "scale"], Float[Array, "scale"], Float[Array, "scale"]]:
        """The scatter scale, reading scale and log prior weight of every point of the grid. [1], [1], [nat]"""
        scatter, reading, *_, log_prior = _grid(self)
        return scatter, reading, log_prior

    def motor_scales(self) -> Float[Array, "scale"]:
        """The scale of the scatter in the quantities of `scaled_by_motors`, for every point of the grid. [1]"""
        return _grid(self)[2 if self.motors else 0]

    def document_scales(self) -> Float[Array, "scale"]:
        """The scale of `documents`, for every point of the grid. [1]"""
        if self.documents is None:
            return np.ones(len(self.scales()[0]))
        return _grid(self)[-2]

    def scale_of(self, quantity: str) -> Literal["scatter", "motors", ""]:
        """Which scale the scatter of single flights in a quantity has; empty for recorded weather, whose error is
        stated."""
        if quantity in UNCERTAIN_WEATHER:
            return ""
        return "motors" if self.motors and quantity in self.scaled_by_motors else "scatter"

    @property
    def unknown_scales(self) -> tuple[Scale, ...]:
        """The scales that the grid runs over: `scatter`, `reading`, and `motors` and `documents` if they are
        unknown."""
        return tuple(one for one in (self.scatter, self.reading, self.motors, self.documents) if one)

    def with_scales(self, *scales: Scale) -> "Hyperprior":
        """A copy with other grids, in the order of `unknown_scales`."""
        names = [name for name in ("scatter", "reading", "motors", "documents") if getattr(self, name)]
        return replace(self, **dict(zip(names, scales, strict=True)))  # type: ignore[arg-type]  # each is a scale

    def json(self) -> dict[str, Any]:
        """The card, in the form that `read_card` reads."""
        return {**self.about, **self.model_json()}

    def model_json(self) -> dict[str, Any]:
        """The figures of the card, without the record of its training data."""
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
            **({"motors": {"median": self.motors.median, "log_sd": self.motors.log_sd}} if self.motors else {}),
            "reading": {"median": self.reading.median, "log_sd": self.reading.log_sd},
            "opening_s": list(self.opening),
            "tail": self.tail,
            "design_drag": self.design_drag,
            "high_power": self.high_power,
        }


@lru_cache(maxsize=64)
def _grid(hyperprior: Hyperprior) -> tuple[Float[Array, "scale"], ...]:
    """As `scale_grid`, without comparing the scales again and again."""
    return scale_grid(hyperprior.unknown_scales)


SCATTER_GRID = tuple(float(x) for x in np.round(np.geomspace(0.1, 4.0, 9), 4))
MOTOR_RANGE = (0.25, 4.0)
READING_GRID = tuple(float(x) for x in np.round(np.geomspace(0.2, 3.0, 5), 4))
"""Grids used during a fit; the final posterior uses grids around their mode."""
FLYER_SPREAD, ROCKET_SPREAD, READING_SPREAD = 0.7, 0.3, 0.7
MOTOR_SPREAD = 0.5
"""Standard deviations of the logarithms of scales: of the scatter of flights among flyers and among a flyer's rockets,
of the noise among devices, and of the scatter of motors among flyers. Flights of most flyers scatter by 3 to 15%: if
three in four are between, the first is log(5) / 2.3. With nine in ten (0.5) a contest team whose flights scatter by 2%
does not earn its narrow interval in eight flights. Motors of one type scatter by at most 6.7%, or they are not
certified (NFPA 1125): with a median of 2.5%, 0.5 leaves one type in 40 beyond. [1]"""


def _motors(median: float, log_sd: float) -> Scale:
    """The scale of the scatter of motors. One value during a fit, because a third grid would multiply its time."""
    return Scale((median,), median, log_sd, ends=MOTOR_RANGE, points=4, spread=MOTOR_SPREAD)


def _scatter(median: float, log_sd: float) -> Scale:
    return Scale(
        SCATTER_GRID, median, log_sd, spread=float(np.hypot(FLYER_SPREAD, ROCKET_SPREAD)), within=ROCKET_SPREAD
    )


def _reading(median: float, log_sd: float) -> Scale:
    return Scale(READING_GRID, median, log_sd, spread=READING_SPREAD)


START = Hyperprior(
    kind="learned",
    means=MappingProxyType({"drag": float(np.log(0.6)), "mass": 0.0, "apogee": 0.0}),
    sds=MappingProxyType(
        {
            "drag.fleet": 0.15,
            "drag.rocket": 0.3,
            "drag.config": 0.05,
            "drag.flight": 0.03,
            "thrust.fleet": 0.02,
            "thrust.motor": 0.05,
            "thrust.lot": 0.025,
            "thrust.flight": 0.025,
            "mass.fleet": 0.05,
            "mass.drift": 0.05,
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
            "peak_accel.motor": 0.1,
            "coast_to_apogee.fleet": 0.05,
            "coast_to_apogee.rocket": 0.03,
            "apogee_to_eject.fleet": 0.1,
            "apogee_to_eject.rocket": 0.1,
            "top_speed.logged": 0.03,
            "burn_time.logged": 0.03,
            "peak_accel.logged": 0.1,
            "coast_to_apogee.logged": 0.03,
            "apogee_to_eject.logged": 0.1,
            "coast_drag.rocket": 0.04,
            "coast_drag.ports": 0.21,
            "burn_impulse.rocket": 0.05,
        }
    ),
    fixed=(1.0, 0.3, 0.05, 0.5, 0.05, 0.5, 0.0, 0.0),
    ratio=(0.005, 0.05, 0.05, 0.15, 0.05, 0.0, 0.05, 0.03),
    unknown_area=0.2,
    scatter=_scatter(1.0, 0.7),
    reading=_reading(1.0, 0.7),
    motors=_motors(1.0, 0.7),
)
"""The starting point of the fit: round figures chosen before any flight was seen. Cd is as in `CERTIFIED_PRIOR`. Motor
types are within 5% of their certificates (certification tests differ by that much; single motors by 6.7%, NFPA 1125),
their lots within 2.5% of the type if flights record them, burn times within 5% and delays within 10%. Masses are within
5%, because altimeter, recovery and wadding are not always weighed, which adds mass: the mean is learned. Recorded once,
they change by repairs and fittings: by 5% a year. Devices of one kind share a bias of 5%, that of peak acceleration
also by motor type, as they smooth short spikes. Single flights scatter by 6%. The biases of devices have mean zero,
because manufacturers aim at the truth; the variation of noise among devices (`reading`) is a judgment. Readouts
measured in samples have no bias of a device. Drag and impulse from a log have the standard deviation of the analysis
(`ratio` is used if it is missing). A climb 15 degrees off vertical has 1/cos 15 = 1.035 times the drag and 0.97 times
the impulse. Static ports change a drag from a barometer (`fieldkit.analysis.drag_and_impulse.PORTS_SD`). Two altimeters
on one open flight differ by 13% in drag and 9% in impulse."""

_JUDGED_SDS = {key: sd for key, sd in START.sds.items() if key.endswith((".logged", ".lot", ".ports"))}
"""Values that cards of older versions lack: judgments, because no open flight has a readout of both kinds or a lot."""


@cache
def learned() -> Hyperprior:
    """The hyperprior in use: the flyer's from `fieldkit learn --keep`, otherwise the one shipped with fieldkit.

    Raises DamagedModel if the card cannot be read.
    """
    own = hyperprior_file()
    if own.exists():
        try:
            return read_card(read_own(own), str(own))
        except (OSError, UnicodeDecodeError) as error:
            raise DamagedModel(f"{own}: cannot be read ({error}), expected a hyperprior card") from error
    return read_card(files("fieldkit.data").joinpath(CARD).read_text("utf-8"), CARD)


def _noise_of(card: Mapping[str, Any], readout: str) -> Mapping[str, float]:
    """The noise of a readout. One that a card lacks, because its version did not compare that readout, is `START`'s."""
    place = READOUTS.index(readout)
    start = {"fixed": START.fixed[place], "ratio": START.ratio[place]}
    noise: Mapping[str, float] = card["noise"][readout] if readout == "apogee" else card["noise"].get(readout, start)
    return noise


def read_card(text: str, name: str) -> Hyperprior:
    """A hyperprior from its card. Raises DamagedModel, naming the card, if its values are impossible."""
    try:
        card = json.loads(text)
        noise = [_noise_of(card, readout) for readout in READOUTS]
        found = Hyperprior(
            kind="learned",
            means=MappingProxyType({key: float(x) for key, x in card["means"].items()}),
            mean_sds=MappingProxyType({key: float(x) for key, x in card.get("mean_sds", {}).items()}),
            sds=MappingProxyType({key: float(x) for key, x in (_JUDGED_SDS | card["sds"]).items()}),
            fixed=tuple(float(one["fixed"]) for one in noise),
            ratio=tuple(float(one["ratio"]) for one in noise),
            unknown_area=float(card["unknown_area"]),
            scatter=_scatter(float(card["scatter"]["median"]), float(card["scatter"]["log_sd"])),
            reading=_reading(float(card["reading"]["median"]), float(card["reading"]["log_sd"])),
            motors=_motors_of(card),
            opening=(float(card["opening_s"][0]), float(card["opening_s"][1])),
            tail=float(card["tail"]),
            design_drag=float(card.get("design_drag", DESIGN_DRAG)),
            high_power=float(card.get("high_power", 1.0)),
        )
    except (ValueError, RecursionError, OverflowError, KeyError, TypeError, AttributeError, IndexError) as error:
        raise DamagedModel(f"{name}: found {error!r}, expected a hyperprior as `fieldkit learn` writes it") from error
    positive = [*found.sds.values(), *found.mean_sds.values(), *found.fixed, *found.ratio, found.unknown_area]
    never_zero = [found.tail, found.opening[1], found.design_drag, found.high_power]
    never_zero += [end for scale in found.unknown_scales for end in (scale.median, scale.log_sd)]
    values = [*found.means.values(), found.opening[0], *positive, *never_zero]
    unknown = [key for key in found.sds if not _known(key)]
    if unknown or not np.isfinite(values).all() or min(positive) < 0 or min(never_zero) <= 0:
        wrong = f"the unknown effect {unknown[0]!r}" if unknown else "a figure that is zero, negative or not finite"
        raise DamagedModel(f"{name}: found {wrong}, expected standard deviations of {', '.join(QUANTITIES)}")
    about = {key: value for key, value in card.items() if key not in found.json()}
    return replace(found, about=MappingProxyType(about))


def _motors_of(card: Mapping[str, Any]) -> Scale | None:
    """The scale of the scatter of motors, which cards of older versions lack, or leave to judgment with a scale `of`
    the scatter of the apogee alone."""
    if "motors" in card:
        return _motors(float(card["motors"]["median"]), float(card["motors"]["log_sd"]))
    return START.motors if card["scatter"].get("of") == "apogee" else None


def _known(key: str) -> bool:
    quantity, _, level = key.partition(".")
    return quantity in (*QUANTITIES, "tilt") and level in LEVELS
