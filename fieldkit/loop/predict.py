"""The next flight, as a distribution: the posterior of a rocket's model, flown many times.

Draws of the shared unknowns come from the posterior, scatter and reading errors anew for every flight, and
all of them fly in one batch. With no flight to learn from the priors are flown, and the prediction says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.loop.candidates import Place, effect_terms
from fieldkit.loop.fit import Fit, fit_robustly, leave_one_out, own_reading_sd, scale_grid
from fieldkit.loop.model import SCATTER, Model, base_model, bent, observe, shown
from fieldkit.loop.spread import tails
from fieldkit.loop.tangent import lean_slope
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float
from fieldkit.simulator.effect import effects, spoken
from fieldkit.simulator.field import recorded

DRAWS = 1000
"""Flights flown for each prediction: their error of a 5 % quantile is about a tenth of the spread."""
FORECAST_SLACK = 3.0
"""How far motors are taken to be from their certificate, and masses from the scales, in a forecast. [1]"""
LEVELS = (0.05, 0.5, 0.95)


@dataclass(frozen=True, slots=True)
class Prediction:
    """What the altimeter will show of a planned flight, as draws of the apogee and figures drawn with it. SI.

    `coast` is from top speed to apogee, `eject` from apogee to the ejection charge (nan without a delay),
    `cd` and `alpha` the drag coefficient and thrust factor flown with. `rests_on` counts the flights that
    taught the model. `stretched_by` is by what the spread of `apogee` was multiplied because of how
    `earlier_forecasts` fared, 1 where there are too few of them.
    """

    plan: Flight
    found: Found
    apogee: Float[Array, "draw"]
    true_apogee: Float[Array, "draw"]
    eject: Float[Array, "draw"]
    coast: Float[Array, "draw"]
    top_speed: Float[Array, "draw"]
    rail_speed: Float[Array, "draw"]
    eject_speed: Float[Array, "draw"]
    cd: Float[Array, "draw"]
    alpha: Float[Array, "draw"]
    rests_on: int
    model: str
    stretched_by: float = 1.0
    earlier_forecasts: int = 0

    def apogee_quantiles(self) -> Float[Array, "level"]:
        """At 5, 50 and 95 %. [m]"""
        return np.asarray(np.quantile(self.apogee, LEVELS))

    def corrected(self, factor: float | None, earlier: int) -> "Prediction":
        """The same with the spread of the apogee multiplied about its median, by ratio; None changes nothing."""
        if factor is None:
            return self
        return replace(self, apogee=apart(self.apogee, factor), stretched_by=factor, earlier_forecasts=earlier)

    @property
    def median_eject(self) -> float | None:
        """From apogee to the ejection charge, or None without a delay. [s]"""
        return median(self.eject)


def apart(apogee: Float[Array, "draw"], factor: float) -> Float[Array, "draw"]:
    """Draws of an apogee further from their median, by ratio; those that stay on the pad are left there."""
    flown = apogee > 0
    if factor == 1.0 or not flown.any():
        return apogee
    middle = np.median(apogee[flown])
    return np.where(flown, middle * (np.where(flown, apogee, middle) / middle) ** factor, apogee)


def median(values: Float[Array, "draw"]) -> float | None:
    """The median of the draws that have a value, or None."""
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else None


def rocket_model(
    flights: Sequence[Flight], found: Sequence[Found], accepted: Sequence[Place] = (), slack: float = 1.0
) -> Model:
    """The model of a rocket with the effects that were accepted into it; `slack` as in `base_model`."""
    model = base_model(flights, found, slack)
    known = [place for place in accepted if place.effect in effects()]
    return model.with_terms(*(term for place in known for term in effect_terms(place, model)))


def model_name(accepted: Sequence[Place]) -> str:
    """`field`, or `field+wind`."""
    return "+".join(["field", *(spoken(place.effect) for place in accepted)])


def predict(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]],
    accepted: Sequence[Place] = (),
    *,
    declared: bool = True,
    draws: int = DRAWS,
    seed: int = 0,
) -> list[Prediction]:
    """Predict planned flights of one rocket from those it has flown, in the order flown.

    Flights with an anomaly tag count as flown and do not teach. Wind that was written down acts with the
    prior of its effect, accepted or not; with `declared` False it does not. Raises ImpossibleFlight for a flight
    without a dry mass.
    """
    both = [*flown, *planned]
    flights, found = [flight for flight, _ in both], [motor for _, motor in both]
    teach = [flight.clean for flight, _ in flown] + [False] * len(planned)
    acting = (*accepted, *declared_places(flights, accepted)) if declared else accepted
    model = rocket_model(flights, found, acting, FORECAST_SLACK)
    taught = [i for i, term in enumerate(model.terms) if np.any(term.weight[: len(flown)] != 0)]
    past = slice(0, max(len(flown), 1))  # without a past, the first plan stands in for one and teaches nothing
    result = fit_robustly(model.part(past).only(taught), observe(flights[past], teach[past]))
    rng = np.random.default_rng(seed)
    values, scales = _drawn(model, taught, result, draws, rng)
    ahead = slice(len(flown), None)
    part = model.part(ahead)
    scatter: dict[str, Array] = {
        kind.bends: rng.normal(size=(draws, len(planned))) * kind.sd * scales[:, :1]
        for kind in SCATTER
        if kind.bends != "tilt"
    }
    readings = shown(part, values, scatter)
    at = np.array([term.mean for term in model.terms])
    at[taught] = result.tangent.at
    slope = lean_slope(part, at)[:, 0]
    lean = slope * rng.normal(size=(draws, len(planned))) * scales[:, :1]
    apogee = readings["apogee"] * np.exp(lean)
    reading = own_reading_sd(apogee) * scales[:, 1:] * rng.normal(size=apogee.shape)
    cd = np.exp(bent(part, values, "drag") + scatter["drag"])
    alpha = np.exp(bent(part, values, "thrust") + scatter["thrust"])
    rests_on = int(np.sum(result.data.seen.any(axis=1)))
    return [
        Prediction(
            plan=flight,
            found=motor,
            apogee=np.nan_to_num(apogee[:, i] * np.exp(reading[:, i])),
            true_apogee=readings["true"][:, i],
            eject=readings["apogee_to_eject"][:, i],
            coast=readings["coast_to_apogee"][:, i],
            top_speed=readings["top_speed"][:, i],
            rail_speed=readings["rail_speed"][:, i],
            eject_speed=readings["eject_speed"][:, i],
            cd=cd[:, i],
            alpha=alpha[:, i],
            rests_on=rests_on,
            model=model_name(accepted),
        )
        for i, (flight, motor) in enumerate(planned)
    ]


def declared_places(flights: Sequence[Flight], accepted: Sequence[Place]) -> list[Place]:
    """Effects whose column was written down, and that no accepted effect stands for already."""
    known = {place.effect for place in accepted}
    return [
        Place(name)
        for name, effect in effects().items()
        if effect.needs and name not in known and np.nanmax(recorded(flights, effect.needs), initial=0.0) > 0
    ]


def _drawn(
    model: Model, taught: Sequence[int], result: Fit, draws: int, rng: np.random.Generator
) -> tuple[Float[Array, "draw term"], Float[Array, "draw 2"]]:
    """Draws of every term: those that act on flown flights from what these taught, the others from their prior.

    Terms of a motor never flown are independent of the flights, so hundreds of motors cost no more to learn.
    """
    learned, scales = sample(result, draws, rng)
    values = np.empty((draws, len(model.terms)))
    values[:, taught] = learned
    for i in sorted(set(range(len(model.terms))) - set(taught)):
        term = model.terms[i]
        values[:, i] = np.clip(rng.normal(term.mean, term.sd, draws), term.low, term.high)
    return values, scales


def sample(
    result: Fit, draws: int, rng: np.random.Generator
) -> tuple[Float[Array, "draw term"], Float[Array, "draw 2"]]:
    """Draws of a model's terms within their bounds, and by what scatter and reading of a flight to come are scaled."""
    scatter_scale, reading_scale, _ = scale_grid()
    which = rng.choice(len(result.weights), size=draws, p=result.weights)
    roots = np.linalg.cholesky(np.linalg.inv(result.precision))
    values = result.mean[which] + np.einsum("dtu,du->dt", roots[which], rng.normal(size=(draws, result.mean.shape[1])))
    lows, highs = (np.array([getattr(term, end) for term in result.model.terms]) for end in ("low", "high"))
    scales = np.stack([scatter_scale[which], reading_scale[which]], axis=-1)
    apart = leave_one_out(result).spread.draw(draws, rng) * tails(draws, rng)
    return np.clip(values, lows, highs), scales * apart[:, None]
