"""The page of the manual on every prior and noise figure of the model."""

from collections.abc import Iterator, Mapping
from typing import Any

from fieldkit.flight.plausibility import IMPULSE_SCATTER
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.documents import CERTIFIED_SCALE
from fieldkit.model.hyperprior import DESIGN_DRAG, READOUTS, START, Hyperprior, learned
from tools.markdown import WRITTEN_BY

MIXED = "mixed with rivals"
SOURCES = {
    "drag": "log Cd: rockets from 0.35 to 1.1 (Mandell et al., 1973; Hoerner, 1965)",
    "thrust": (
        "log ratio of delivered to certified impulse; lots within 2 to 3% (NFPA 1125: single motors within an sd of "
        f"{IMPULSE_SCATTER:.1%})"
    ),
    "mass": "log ratio of flown to recorded mass: altimeter, recovery, wadding",
    "stretch": "log ratio of actual to certified burn time",
    "delay": "log ratio of actual to rated delay (NFPA 1125: within 20% or 1.5 s, whichever is more, at most 3 s)",
    "tilt": "squared launch angle of a single flight, in units of (5 degrees)²",
    "apogee": "log ratio of apogee to the one from drag, thrust and mass",
    "top_speed": "log ratio of the readout to the simulated one",
    "burn_time": "as top speed",
    "peak_accel": "as top speed",
    "coast_to_apogee": "as top speed",
    "apogee_to_eject": "readout minus the simulated one [s]",
    "coast_drag": "log ratio of drag in a log to the simulated one; 15 degrees off vertical adds 3.5%",
    "burn_impulse": "log ratio of impulse per mass in a log to the simulated one; 15 degrees off vertical subtracts 3%",
}
"""Definition of each random effect, and the source of its starting figure."""


def prior_table() -> str:
    """Every prior and noise figure of the model with its source."""
    card, given = learned(), CERTIFIED_PRIOR
    names = list(dict.fromkeys([*card.sds, *given.sds]))
    names.sort(key=lambda name: list(SOURCES).index(name.partition(".")[0]))
    rows = [_random_effect(name, card, given) for name in names]
    firsts = [name.partition(".")[0] for name in names]
    rows = [
        row if kind not in firsts[:place] else row.replace(SOURCES[kind], "")
        for place, (kind, row) in enumerate(zip(firsts, rows, strict=True))
    ]
    units = ("m", "m/s", "s", "m/s²", "s", "s", "1/m", "m/s")
    noise = [
        f"| {readout.replace('_', ' ')} | {fixed:.3g} {unit}, {ratio:.3g} | {fixed2:.3g} {unit}, {ratio2:.3g} |"
        for readout, unit, fixed, ratio, fixed2, ratio2 in zip(
            READOUTS, units, card.fixed, card.ratio, given.fixed, given.ratio, strict=True
        )
    ]
    means = [
        f"| {name.replace('_', ' ')} | {START.mean(name):.3f} | {card.mean(name):.3f} | {card.mean_sds[name]:.3f} |"
        for name in card.means
    ]
    data = [
        f"| {one['flyer'].replace('_', ' ')} | {one['flights']} | {one['rockets']} | {_digests(one['sha256'])} |"
        for one in card.about["data"]
    ]
    return f"""# Every prior and noise figure

The model behind every forecast: the logarithm of each quantity is a mean plus random effects of the flyer's fleet, the
rocket, its configuration, the motor type, the rocket on that motor, the day and the single flight. The standard
deviations of these effects are the hyperprior. *Start* has the round figures from which the fit starts. *Learned* is
the result of fitting real flights, `fieldkit/data/hyperprior.json`; forecasts use it. *Exact* has those of a flyer
whose motors, masses and devices match their documents. How far they do is unknown: one scale multiplies the standard
deviations of effects that are deviations from documents, in the power that leads from *start* at 1 to *exact* at
{CERTIFIED_SCALE:g} (1 for an effect that *exact* lacks). It is half-Cauchy around 1 and weighed by the flights of a
rocket, in forecasts from *learned*, in the loop from *start*, so that an effect explains a difference only if other
motors and masses agree with their documents. {WRITTEN_BY}

| quantity | varies by | start | learned | exact | definition and source |
|---|---|---|---|---|---|
{chr(10).join(rows)}

| mean over all flyers | start | learned | standard deviation |
|---|---|---|---|
{chr(10).join(means)}

The biases of devices have mean zero. The mean of a flyer's fleet varies by the variation among fleets plus the standard
deviation of the overall mean. *Drift* is its change in one year since the first flight, independent of other years.
*Logged* is for readouts measured in
the samples of a log. *Ports* is for the drag in the log of a barometer, which static ports change: by 0.12 if they are
off by 3% of the dynamic pressure, and more in real flights with an accelerometer beside the barometer (`python -m
tools.drags`).

The noise of a readout has a constant part and a part proportional to it. A factor for each rocket scales the scatter of
its {"apogees" if card.motors else "flights"}; another scales the noise of its readouts.
{_of_motors(card)}Single flights and readouts follow a Student t with
{card.tail:g} degrees of freedom. A recorded standard deviation of a readout replaces these figures.

| readout | learned | exact |
|---|---|---|
{chr(10).join(noise)}

The log Cd of a rocket with a design has a standard deviation of {card.design_drag:.3f} around the Cd of the design
(start {DESIGN_DRAG:g}, an expert judgment). The random effects of mass, thrust and apogee of such a rocket on
high-power motors are multiplied by {card.high_power:.2f} (start 1).

The log frontal area of a rocket without a recorded diameter has a standard deviation of {card.unknown_area:.2f}
(learned together with drag). The parachute opens in
{card.opening[0]:g} ± {card.opening[1]:g} s.

[The effects](effects.md) have the priors of their strengths, and [the trained ensembles](models.md) those of the
simulated flights of the paper's network.

## Training data

`{card.about["command"]}`, log evidence {card.about["log_evidence"]["before"]:.1f} with the start,
{card.about["log_evidence"]["after"]:.1f} with the learned hyperprior.

| flyer | flights | rockets | sha256 of the files |
|---|---|---|---|
{chr(10).join(data)}
{chr(10).join(_held_out(card.about.get("scores", {}), card.about.get("scores_by_readouts", {})))}
{chr(10).join(_high_power(card.about.get("high_power_flights", {})))}"""


def _held_out(scores: Mapping[str, Any], by_readouts: Mapping[str, Any]) -> Iterator[str]:
    """CRPS and coverage on rockets that the training did not see, with the simple rule of the lowest CRPS."""
    if not scores:
        return
    yield """
## Held-out rockets

Each flight of a rocket is forecast from the earlier ones of this and the flyer's other rockets, with a hyperprior
learned without that rocket. CRPS in percent of the flown apogee. [All methods and readouts](measured/prior_scores.md).

| flyer | flights | fieldkit | in the 90% interval | simple rule with the lowest CRPS |
|---|---|---|---|---|"""
    for flyer, tables in scores.items():
        rows = {row["name"]: row for row in tables["after earlier flights of the rocket"]}
        own = rows.pop("fieldkit")
        best = min((row for name, row in rows.items() if name != MIXED), key=lambda row: float(row["crps"]))
        rule = f"{LABELS.get(best['name'], best['name'])}, {100 * best['crps']:.1f}"
        cells = (flyer.replace("_", " "), own["flights"], f"{100 * own['crps']:.1f}", f"{own['coverage90']:.0%}", rule)
        yield f"| {' | '.join(map(str, cells))} |"
    for flyer, tables in by_readouts.items():
        first, *_, last = (f"{100 * row['crps']:.1f}" for row in tables["after earlier flights of the rocket"])
        yield f"\nWith the apogee alone the CRPS of the {flyer.replace('_', ' ')} is {first}, with all readouts {last}."


def prior_scores() -> str:
    """Scores of forecasts of rockets that the hyperprior did not see, as `fieldkit learn --check` printed them."""
    about = learned().about
    return f"""# Forecasts of rockets that the priors did not see

Scores of `{about["command"]}` with `--check`,
on the commit that learned [the priors](../priors.md). {WRITTEN_BY}
{chr(10).join(_left_out_tables(about.get("scores", {})))}
{chr(10).join(_step_tables(about.get("scores_by_readouts", {})))}"""


def _of_motors(card: Hyperprior) -> str:
    if not card.motors:
        return ""
    return (
        "A third scales the scatter of thrust, drag, burn time and delay. All have a heavy tail (hyperbolic secant in "
        "the logarithm), because few flyers do not determine them, and each flyer's flights do: flights of different "
        "flyers scatter by 3 to 15%. The scatter of one rocket's flights says what to expect of the flyer's next. "
    )


def _high_power(record: Mapping[str, Any]) -> Iterator[str]:
    """The flights behind the figures for high power, and how well they are forecast."""
    if not record:
        return
    density = record["log_density"]
    yield f"""
## High-power flights

`{record["command"]}`: {record["flights"]} first flights of {record["rockets"]} rockets, each with the apogees forecast
by two design programs (AidanSYu/rocket-flight-database, CC BY 4.0; sha256 `{record["sha256"][:12]}`). Dry mass and Cd
are those with which the simulation has the forecast apogee and top Mach number. The log density of the flown apogees is
{density["before"]:.1f} with the figures of model rockets and {density["after"]:.1f} with the fitted ones.

Each rocket is forecast with figures fitted to the others, in percent of the forecast apogee. *Program, mean ratio* is
normal with the mean and standard deviation of the other rockets' ratios. Its intervals are narrower and its scores
better, because the two figures of fieldkit stay near their starts. That caution is deliberate: some of these forecasts
were fitted after the flight.

| method | mean error | CRPS | interval score | coverage |
|---|---|---|---|---|"""
    for row in record["scores"]:
        shares = " | ".join(f"{100 * row[name]:.1f}" for name in ("mean_share", "crps", "interval_score"))
        yield f"| {row['name']} | {shares} | {row['coverage90']:.0%} |"


def _digests(digests: Mapping[str, str]) -> str:
    return " ".join(f"`{digest[:12]}`" for digest in digests.values())


def _random_effect(name: str, card: Hyperprior, given: Hyperprior) -> str:
    quantity, _, level = name.partition(".")
    cells = [f"{one.sds[name]:.3g}" if one.sds.get(name) else "" for one in (START, card, given)]
    named = "launch angle" if quantity == "tilt" else quantity.replace("_", " ")
    return f"| {named} | {level.replace('_', ' x ')} | {' | '.join(cells)} | {SOURCES[quantity]} |"


def _left_out_tables(scores: Mapping[str, Any]) -> Iterator[str]:
    """Scores on rockets held out of the hyperprior's training, with simpler methods."""
    if not scores:
        return
    yield """
## Held-out rockets

Each flight of a rocket is forecast from the earlier ones, with a hyperprior learned without that rocket. Earlier
flights of the flyer's other rockets are used. All figures are in percent of the flown apogee; the interval score is for
the 90% interval."""
    for flyer, tables in scores.items():
        for title, rows in tables.items():
            yield f"\n### {flyer.replace('_', ' ')}: {title}\n"
            yield "| method | flights | median error | mean error | bias | CRPS | interval score | coverage |"
            yield "|---|---|---|---|---|---|---|---|"
            for row in rows:
                figures = (
                    row["median_share"],
                    row["mean_share"],
                    row["median_bias"],
                    row["crps"],
                    row["interval_score"],
                )
                cells = " | ".join(f"{100 * figure:.1f}" for figure in figures)
                name = LABELS.get(row["name"], row["name"])
                yield f"| {name} | {row['flights']} | {cells} | {row['coverage90']:.0%} |"


def _step_tables(steps: Mapping[str, Any]) -> Iterator[str]:
    """Scores on held-out rockets from more and more readouts."""
    if not steps:
        return
    yield """
## Whether more readouts help

The same forecasts of held-out rockets, from some readouts of the earlier flights and from all. *Less* is how much
smaller the CRPS is than in the row above, with its 90% bootstrap interval: an interval that contains zero shows no
difference either way. The log score is the mean log density of the flown apogee [nat]; larger is better."""
    for flyer, tables in steps.items():
        for title, rows in tables.items():
            yield f"\n### {flyer.replace('_', ' ')}, {title}\n"
            yield "| readouts | flights | median error | mean error | CRPS | less | log score | coverage |"
            yield "|---|---|---|---|---|---|---|---|"
            for row in rows:
                cells = " | ".join(f"{100 * row[name]:.1f}" for name in ("median_share", "mean_share", "crps"))
                less = ""
                if "crps_less" in row:
                    low, high = (100 * end for end in row["crps_less90"])
                    less = f"{100 * row['crps_less']:+.1f} ({low:+.1f} to {high:+.1f})"
                log_score, coverage = f"{row['log_score']:+.2f}", f"{row['coverage90']:.0%}"
                yield f"| {row['name']} | {row['flights']} | {cells} | {less} | {log_score} | {coverage} |"
