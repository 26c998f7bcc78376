"""The next flight, as a distribution: the posterior of a rocket's model, flown many times.

Draws of the shared unknowns come from the posterior, scatter and reading errors anew for every flight, and
all of them fly in one batch. With no flight to learn from the priors are flown, and the prediction says so.
What is said of a plan does not hang on the plans that it is asked with: each flies on the same draws as it would alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.prediction import Prediction
from fieldkit.inference.laplace.apogee_scatter import tails
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.leave_one_out import leave_one_out, own_reading_sd
from fieldkit.inference.laplace.linearization import lean_of_apogee
from fieldkit.inference.laplace.outliers import fitting
from fieldkit.inference.laplace.posterior import Fit, apogee_scale, scale_grid, term_sds
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import EXTRAS, SCATTER, Model, bent, doubted, shown
from fieldkit.motors import Found
from fieldkit.physics.effect import effects, spoken
from fieldkit.physics.setups import recorded
from fieldkit.selection.candidates import Place
from fieldkit.selection.extended_model import rocket_model
from fieldkit.shapes import Array, Float, Int, Integers

DRAWS = 1000
"""Flights flown for each prediction: their error of a 5 % quantile is about a tenth of the spread."""
FORECAST_SLACK = 3.0
"""How far motors are taken to be from their certificate, and masses from the scales, in a forecast. [1]"""
DESIGN_CD_SD = 0.2
"""Of the logarithm of a Cd that a design program computed: between the 0.35 of any rocket and what flights can tell,
for paint, lugs and gaps are seldom as drawn. A judgement, which flights soon outweigh. [1]"""


def forecast_model(
    flights: Sequence[Flight],
    found: Sequence[Found],
    accepted: Sequence[Place] = (),
    flown: int | None = None,
    turns: Sequence[int] | None = None,
) -> Model:
    """The model of a rocket that its next flight is forecast with; `flown` and `turns` as in `rocket_model`."""
    return doubted(rocket_model(flights, found, accepted, FORECAST_SLACK, flown, turns))


def model_name(accepted: Sequence[Place]) -> str:
    """`field`, `field+wind`, or `field+unexplained`."""
    return "+".join(["field", *(spoken(place.effect) or "unexplained" for place in accepted)])


@dataclass(frozen=True, slots=True)
class Learnt:
    """What a rocket's flights taught of planned ones: draws of every term, ready to be flown.

    `model` is that of the planned flights, `at` the point where the posterior is centred. `rests_on` counts the
    flights that taught it, `name` names it; from `rng` comes the luck of single flights. `left_out` as in `Prediction`.
    """

    model: Model
    at: Float[Array, "term"]
    values: Float[Array, "draw term"]
    scales: Float[Array, "draw 2"]
    rests_on: int
    name: str
    rng: np.random.Generator
    left_out: tuple[str, ...] = ()


def predict(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]],
    accepted: Sequence[Place] = (),
    *,
    declared: bool = True,
    cds: Mapping[str, float] | None = None,
    draws: int = DRAWS,
    seed: int = 0,
) -> list[Prediction]:
    """Predict planned flights of one rocket from those it has flown, in the order flown.

    The plans are flown one after the other, which matters to what grows from flight to flight and to nothing else.
    Flights with an anomaly tag count as flown and do not teach, nor do readouts that do not fit their flight. Wind
    that was written down acts with the prior of its effect, accepted or not; with `declared` False it does not. `cds`
    are those of designs by configuration, which are believed before any flight in place of that of any rocket [1].
    Raises ImpossibleFlight for a flight without a dry mass.
    """

    def said(rows: Sequence[int]) -> list[Prediction]:
        own, turns = [planned[row] for row in rows], [len(flown) + row for row in rows]
        taught = learn(flown, own, accepted, turns, declared=declared, cds=cds, draws=draws, seed=seed)
        return fly_ahead(taught, paired=True)

    return by_kind(flown, planned, said)


def learn(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]],
    accepted: Sequence[Place] = (),
    turns: Sequence[int] | None = None,
    *,
    declared: bool = True,
    cds: Mapping[str, float] | None = None,
    draws: int = DRAWS,
    seed: int = 0,
) -> Learnt:
    """Fit the flights flown, for planned ones of a kind (see `fieldkit.forecast.kinds`), each with its turn in the
    order flown, by default the next for all of them; the rest as in `predict`."""
    both = [*flown, *planned]
    flights, found = [flight for flight, _ in both], [motor for _, motor in both]
    flights[: len(flown)], left_out = fitting(flights[: len(flown)], found)
    teach = [flight.clean for flight, _ in flown] + [False] * len(planned)
    acting = (*accepted, *declared_places(flights, accepted)) if declared else accepted
    order = [*range(len(flown)), *(turns or [len(flown)] * len(planned))]
    model = forecast_model(flights, found, acting, len(flown), order)
    own = {flight.config: cds[flight.config] for flight in flights if cds and flight.config in cds}
    model = _designed(model, own) if own else model
    acted = [i for i, term in enumerate(model.terms) if np.any(term.weight[: len(flown)] != 0)]
    taught = acted or [0]  # of a rocket never flown, one prior stands in for what was learned
    past = slice(0, max(len(flown), 1))  # without a past, the first plan stands in for one and teaches nothing
    teaching = replace(model.part(past).only(taught), coarse=True)
    result = fit_robustly(teaching, observe(flights[past], teach[past]))
    rng = np.random.default_rng(seed)
    values, scales = _drawn(model, taught, result, draws, rng)
    at = np.array([term.mean for term in model.terms])
    at[taught] = result.tangent.at
    rests_on = int(np.sum(result.data.seen.any(axis=1)))
    return Learnt(
        model.part(slice(len(flown), None)), at, values, scales, rests_on, model_name(accepted), rng, left_out
    )


def _designed(model: Model, cds: Mapping[str, float]) -> Model:
    """The model of a rocket with designs: each configuration starts from its own Cd, and what flights of one show of
    how far the design is off serves the others."""
    logs = {config: float(np.log(cd)) for config, cd in cds.items()}
    middle = float(np.mean(list(logs.values())))
    model = model.with_prior("drag", middle, DESIGN_CD_SD)
    for config, log in logs.items():
        model = model.with_prior(f"drag of {config}", log - middle)
    return model


def fly_ahead(
    learnt: Learnt,
    *,
    paired: bool = False,
    delay_sd: Float[Array, "flight"] | None = None,
    lean: Float[Array, "flight"] | None = None,
) -> list[Prediction]:
    """Fly the planned flights on what was learnt, each a batch of draws.

    With `paired` all flights share the luck of the day, so that they differ by what is planned alone. `delay_sd` is
    how far delays stray from what is printed, as a ratio, in place of what the model takes; `lean` what a lean does to
    the apogee, where that is known already.
    """
    part, values, scales, rng = learnt.model, learnt.values, learnt.scales, learnt.rng
    shape = (len(values), len(part.flights))

    def luck() -> Array:
        drawn = rng.normal(size=(shape[0], 1) if paired else shape)
        return np.broadcast_to(drawn, shape)

    scatter: dict[str, Array] = {
        kind.bends: luck() * kind.sd * scales[:, :1] for kind in SCATTER if kind.bends != "tilt"
    }
    if delay_sd is not None:
        scatter["delay"] = luck() * delay_sd
    readings = shown(part, values, scatter)
    lean = lean_of_apogee(part, learnt.at) if lean is None else lean
    leaning = luck() * scales[:, :1]
    leant = np.exp(lean * leaning)
    apogee = readings["apogee"] * leant
    # of a hop of a metre the reading's error in ratio knows no bounds
    reading = np.clip(own_reading_sd(apogee) * scales[:, 1:] * luck(), -1.0, 1.0)
    figures = {
        "apogee": np.nan_to_num(apogee * np.exp(reading)),
        "true_apogee": np.nan_to_num(readings["true"] * leant),
        "eject": readings["apogee_to_eject"],
        "coast": readings["coast_to_apogee"],
        "cd": np.exp(bent(part, values, "drag") + scatter["drag"]),
        "alpha": np.exp(bent(part, values, "thrust") + scatter["thrust"]),
        **{name: readings[name] for name in ("top_speed", "duration", *EXTRAS)},
    }
    return [
        Prediction(
            plan=flight,
            found=motor,
            rests_on=learnt.rests_on,
            model=learnt.name,
            left_out=learnt.left_out,
            luck=tuple(drawn[:, i] for drawn in (*scatter.values(), leaning, reading)),
            **{name: values[:, i] for name, values in figures.items()},  # type: ignore[arg-type]  # of draws, all
        )
        for i, (flight, motor) in enumerate(zip(part.flights, part.found, strict=True))
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

    Terms of a motor never flown are independent of the flights, so hundreds of motors cost no more to learn. Those of
    one kind, such as the thrust of each motor, share their luck: a motor is as lucky beside others as it is alone.
    """
    learned, which = _sampled(result, draws, rng)
    sds = term_sds(model)[which]
    values = np.empty((draws, len(model.terms)))
    values[:, taught] = learned
    luck: dict[str, Float[Array, "draw"]] = {}
    for i in sorted(set(range(len(model.terms))) - set(taught)):
        term = model.terms[i]
        kind = term.name.partition(" of ")[0]
        luck[kind] = luck[kind] if kind in luck else rng.normal(size=draws)
        values[:, i] = np.clip(term.mean + sds[:, i] * luck[kind], term.low, term.high)
    return values, _scales(result, which, rng)


def sample(
    result: Fit, draws: int, rng: np.random.Generator
) -> tuple[Float[Array, "draw term"], Float[Array, "draw 2"]]:
    """Draws of a model's terms within their bounds, and by what scatter and reading of a flight to come are scaled."""
    values, which = _sampled(result, draws, rng)
    return values, _scales(result, which, rng)


def _sampled(
    result: Fit, draws: int, rng: np.random.Generator
) -> tuple[Float[Array, "draw term"], Int[Integers, "draw"]]:
    """Draws of a model's terms within their bounds, and the pair of scales that each goes with."""
    which = rng.choice(len(result.weights), size=draws, p=result.weights)
    roots = np.linalg.cholesky(result.covariance)
    values = result.mean[which] + np.einsum("dtu,du->dt", roots[which], rng.normal(size=(draws, result.mean.shape[1])))
    lows, highs = (np.array([getattr(term, end) for term in result.model.terms]) for end in ("low", "high"))
    return np.clip(values, lows, highs), which


def _scales(result: Fit, which: Int[Integers, "draw"], rng: np.random.Generator) -> Float[Array, "draw 2"]:
    """By what scatter and the reading of an apogee are scaled for a flight to come, with its tails."""
    scales = np.stack([scale_grid(result.model.doubtful)[0], apogee_scale(result.model)], axis=-1)
    apart = leave_one_out(result).spread.draw(len(which), rng) * tails(len(which), rng)
    return np.asarray(scales[which] * apart[:, None])
