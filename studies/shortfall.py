"""Why measured flights fall short of their simulation: the contribution of each cause, and which causes can be
distinguished.

Causes are added one after the other to a model of all rockets of a ledger, and every flight is forecast from the
earlier flights of all rockets. No prior mean of a cause comes from flights: causes start at the values of certificates,
scales and devices, with the standard deviations of the learned hyperprior, so their estimates come from earlier flights
only.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log
from textwrap import fill

import numpy as np

from fieldkit.errors import NoFlights
from fieldkit.forecast.evaluation.forward_in_time import Forecast, forward
from fieldkit.forecast.evaluation.uncalibrated import NOMINAL_CD, Simulated, simulate
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.fleet import merged, rocket_fit
from fieldkit.model.fleet_drift import period_of
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import FlownFlight, base_model
from fieldkit.model.shared_prior import SharedPrior, combined
from fieldkit.model.simulated_readouts import REFERENCE_LAUNCH_ANGLE
from fieldkit.model.term_names import TermName, fleet_term
from fieldkit.physics.history import flown_and_planned
from fieldkit.progress import ReportProgress, no_op
from fieldkit.quantities import counted
from fieldkit.safe_text import as_markdown
from fieldkit.shapes import Array, Float

PERMANENT_QUANTITIES = ("delay", "coast_drag", "burn_impulse")
"""Quantities in every model: the delay does not affect the climb, and the others can only be measured in logs."""
CAUSES: Mapping[str, tuple[str, ...]] = {
    "launch angle and weathercocking": (),
    "impulse and burn against certificate": ("thrust", "stretch"),
    "mass": ("mass",),
    "drag": ("drag",),
    "the device, and what is wrong with the model": OBSERVED_READOUTS,
}
"""Causes in the order in which they are added, each with its quantities in the model."""
ASSUMED_LAUNCH_ANGLE = REFERENCE_LAUNCH_ANGLE
"""Launch angle of flights without a recorded rail angle. [rad]"""
FIXED_SD = 1e-3
"""Standard deviation of quantities that are fixed at their mean. [1]"""
FLEET_SD = {"drag": 0.14, "thrust": 0.05, "mass": 0.1}
"""Standard deviation of a common bias of a flyer's rockets: a judgment, wide enough for unweighed and uncertified
parts. [1]"""
WIDE_DEVICE_SD = 0.1
"""Standard deviation of a device's common bias over a flyer's flights. [1]"""

KNOWS_NOTHING = 0.995
"""Flights do not constrain a quantity if posterior over prior standard deviation is above this. [1]"""


@dataclass(frozen=True, slots=True)
class ShortfallStep:
    """Forecasts with all causes up to one."""

    cause: str
    forecasts: tuple[Forecast, ...]

    @property
    def errors(self) -> Float[Array, "flight"]:
        """Relative errors: forecast over flown apogee, minus one. [1]"""
        return np.array([one.p50 / one.flown - 1 for one in self.forecasts])


@dataclass(frozen=True, slots=True, eq=False)
class Shortfall:
    """The results of a ledger.

    `ratio` is the median of flown over simulated apogee, `launch_angle_worth` the mean change of its logarithm by the
    usual launch angle. `joint` is the posterior of the fleet's terms with all causes, and `worth` the mean effect of
    each of its terms on the log apogee. `drift` is the posterior of the changes of the mass in single years.
    """

    flights: int
    ratio: float
    launch_angle_worth: float
    steps: tuple[ShortfallStep, ...]
    joint: SharedPrior
    worth: Float[Array, "term"]
    drift: SharedPrior


def shortfall(flown: Sequence[FlownFlight], on_progress: ReportProgress = no_op) -> Shortfall:
    """Trace the shortfall of all flights of a ledger, in the order flown.

    Raises NoFlights if none is clean and has an apogee.
    """
    simulated, inclined = _measured(flown), _measured(at_an_angle := _at_an_angle(flown))
    if not simulated:
        raise NoFlights("found no normal flight with an apogee that can be simulated, expected at least one")
    steps, known = [], restricted(())
    quantities: tuple[str, ...] = ()
    for number, (cause, own) in enumerate(CAUSES.items()):
        on_progress(cause, number / (len(CAUSES) + 1))
        quantities = (*quantities, *own)
        known = restricted(quantities)
        steps.append(ShortfallStep(cause, tuple(forward(at_an_angle, hyperprior=known))))
    pairs = zip(steps[0].forecasts, simulated, strict=True)
    bare = ShortfallStep("nothing: uncalibrated", tuple(_uncalibrated(row, one.simulated) for row, one in pairs))
    on_progress("all rockets together", len(CAUSES) / (len(CAUSES) + 1))
    joint, worth, drift = _together(at_an_angle, known)
    ratio = float(np.median([one.ratio for one in simulated]))
    both = zip(inclined, simulated, strict=True)
    worth_of_angle = float(np.mean([log(one.simulated / other.simulated) for one, other in both]))
    return Shortfall(len(simulated), ratio, worth_of_angle, (bare, *steps), joint, worth, drift)


def _measured(flown: Sequence[FlownFlight]) -> list[Simulated]:
    """The clean flights with an apogee, with their uncalibrated simulations."""
    return [one for one in simulate(flown) if one.flight.clean and one.flight.apogee is not None]


def _at_an_angle(flown: Sequence[FlownFlight]) -> list[FlownFlight]:
    """The flights with the usual launch angle if none was recorded."""
    return [
        (flight if flight.rail_angle is not None else flight.with_changes(rail_angle=ASSUMED_LAUNCH_ANGLE), motor)
        for flight, motor in flown
    ]


def restricted(quantities: Sequence[str]) -> Hyperprior:
    """The learned hyperprior with some quantities free, without prior means from flights."""
    whole = learned()
    free = {*quantities, *PERMANENT_QUANTITIES}
    sds = {name: sd for name, sd in whole.sds.items() if name.partition(".")[0] in free or name.endswith(".flight")}
    for name in free & set(FLEET_SD):
        sds[f"{name}.fleet"] = FLEET_SD[name]
    for name in free & (set(OBSERVED_READOUTS) - {"apogee_to_eject", *PERMANENT_QUANTITIES}):
        sds[f"{name}.fleet"] = WIDE_DEVICE_SD
    unknown_area = whole.unknown_area
    if "drag" not in free:
        sds["drag.rocket"] = unknown_area = FIXED_SD
    return replace(whole, means={"drag": log(NOMINAL_CD)}, sds=sds, unknown_area=unknown_area)


def _uncalibrated(row: Forecast, middle: float) -> Forecast:
    return replace(row, p05=middle, p50=middle, p95=middle)


def _together(
    flown: Sequence[FlownFlight], hyperprior: Hyperprior
) -> tuple[SharedPrior, Float[Array, "term"], SharedPrior]:
    """The posterior of the fleet's terms, the effect of each on the apogees, and the posterior of their drift."""
    rockets: dict[str, list[FlownFlight]] = {}
    for flight, motor in flown:
        rockets.setdefault(flight.rocket, []).append((flight, motor))
    used = [own for own in rockets.values() if any(one.clean and one.readouts() for one, _ in own)]
    period = period_of(flight for own in used for flight, _ in own)
    fits = [rocket_fit(own, hyperprior, period) for own in used]
    posterior = combined(merged([one.prior for one in fits]), [one.message for one in fits])
    names = [name for name in posterior.names if name.level == "fleet" and name.quantity != "delay"]
    joint = posterior.only(names)
    slopes = np.concatenate([_apogee_slopes(own, hyperprior, joint.names) for own in used])
    prior = np.array([log(NOMINAL_CD) if name == fleet_term("drag") else 0.0 for name in joint.names])
    worth = np.asarray(slopes.mean(axis=0) * (joint.mean - prior))
    return joint, worth, posterior.only(name for name in posterior.names if name.level == "drift")


def _apogee_slopes(
    flown: Sequence[FlownFlight], hyperprior: Hyperprior, names: Sequence[TermName]
) -> Float[Array, "flight term"]:
    """Change of the log apogee of a rocket's clean flights per unit of each term; 0 if its model does not have the
    term.

    A rocket whose speeds were measured in logs has no terms for the bias of devices in them.
    """
    history = flown_and_planned(flown)
    model = replace(base_model(history, hyperprior), coarse=True)
    fit = fit_robustly(model, observe(history, hyperprior))
    rows = fit.data.seen[:, 0] & np.isfinite(fit.tangent.values[:, 0])
    slopes = np.zeros((np.count_nonzero(rows), len(names)))
    for place, name in enumerate(names):
        if name in fit.model.names:
            slopes[:, place] = fit.tangent.slope[rows, 0, fit.model.names.index(name)]
    return slopes


def page(found: Shortfall, *, unnamed: bool = False) -> str:
    """The shortfall as a page of Markdown; `unnamed` numbers the rockets."""
    return (
        "\n".join([*_causes(found), "", *_common_table(found), *_drift(found.drift), "", *_rockets(found, unnamed)])
        + "\n"
    )


def _causes(found: Shortfall) -> Iterator[str]:
    yield "# Why flights fall short of their simulation"
    yield ""
    yield fill(
        f"The median ratio of flown to simulated apogee is {found.ratio:.2f} over {found.flights} normal flights "
        f"(uncalibrated simulation: Cd {NOMINAL_CD:g}, certified thrust, recorded mass). In the table, each row adds a "
        "cause to those above it, and every flight is forecast from the earlier ones. Bias is the mean log ratio of "
        "forecast to flown apogee, with its standard error.",
        118,
    )
    yield ""
    yield "| included | flights | bias | median error | mean error | in the 90% interval |"
    yield "|---|---|---|---|---|---|"
    for step in found.steps:
        if not step.forecasts:
            continue
        logs, inside = np.log1p(step.errors), [one.p05 <= one.flown <= one.p95 for one in step.forecasts]
        error, bare = np.abs(step.errors), step is found.steps[0]
        bias = f"{100 * logs.mean():+.1f} ± {100 * logs.std() / np.sqrt(len(logs)):.1f}%"
        covered = "" if bare else f"{np.mean(inside):.0%}"
        yield f"| {step.cause} | {len(logs)} | {bias} | {np.median(error):.1%} | {error.mean():.1%} | {covered} |"


def _common_table(found: Shortfall) -> Iterator[str]:
    """What all rockets have in common, and what cannot be distinguished."""
    yield "## What all rockets have in common"
    yield ""
    yield fill(
        "The deviation of each quantity with every cause included, fitted to all flights together, and its effect on "
        "the apogee. Several quantities have the same effect on flights; the last column names the one that is hardest "
        "to distinguish from each, with their posterior correlation.",
        118,
    )
    yield ""
    yield "| quantity | deviation | change of the apogee | hardest to distinguish from |"
    yield "|---|---|---|---|"
    angle = f"{np.degrees(ASSUMED_LAUNCH_ANGLE):.0f}°, assumed"
    yield f"| launch angle | {angle} | {100 * found.launch_angle_worth:+.1f}% | |"
    sds = np.sqrt(np.diag(found.joint.covariance))
    correlation = found.joint.covariance / np.outer(sds, sds) - np.eye(len(sds))
    for i, name in enumerate(found.joint.names):
        if sds[i] > KNOWS_NOTHING * _prior_sd(name.quantity):
            continue
        quantity = name.quantity.replace("_", " ")
        start = log(NOMINAL_CD) if name == fleet_term("drag") else 0.0
        other = int(np.abs(correlation[i]).argmax())
        rival = found.joint.names[other].quantity.replace("_", " ")
        unit = " s" if quantity == "apogee to eject" else "%"
        scale = 1.0 if unit == " s" else 100.0
        off = f"{scale * (found.joint.mean[i] - start):+.1f} ± {scale * sds[i]:.1f}{unit}"
        yield f"| {quantity} | {off} | {100 * found.worth[i]:+.1f}% | {rival} ({correlation[i, other]:+.2f}) |"


def _drift(drift: SharedPrior) -> Iterator[str]:
    """How the mass has changed since the fleet's first flight; nothing for a fleet that flew on one day."""
    if drift.names:
        yield ""
        change, sd = drift.mean.sum(), np.sqrt(drift.covariance.sum())
        yield fill(
            f"The mass is that at the first flight; {counted(len(drift.names), 'year')} later it has changed by "
            f"{100 * change:+.0f} ± {100 * sd:.0f}%.",
            118,
        )


def _prior_sd(quantity: str) -> float:
    return restricted(sum(CAUSES.values(), ())).sd(quantity, "fleet")


def _rockets(found: Shortfall, unnamed: bool) -> Iterator[str]:
    yield "## Rocket by rocket"
    yield ""
    yield "Mean error of the forecasts of a rocket's flights, each from the earlier ones, as causes are added."
    yield ""
    yield f"| rocket | flights | {' | '.join(step.cause for step in found.steps)} | not worse |"
    yield f"|{'---|' * (len(found.steps) + 3)}"
    names = list(dict.fromkeys(one.rocket for one in found.steps[0].forecasts))
    for number, name in enumerate(names, start=1):
        rows = [row for row, one in enumerate(found.steps[0].forecasts) if one.rocket == name]
        errors = [float(np.abs(step.errors[rows]).mean()) for step in found.steps]
        label = str(number) if unnamed else as_markdown(name)
        cells = " | ".join(f"{error:.0%}" for error in errors)
        yield f"| {label} | {len(rows)} | {cells} | {'yes' if errors[-1] <= errors[0] else 'no'} |"
