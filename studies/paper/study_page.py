"""The reference study as a page of Markdown; every figure in it is computed."""

from collections.abc import Iterator, Sequence
from textwrap import fill

import numpy as np

from fieldkit.physics.effect import effects
from fieldkit.reference.flights import errors
from studies.paper.study import Study, interval
from studies.paper.two_flights import MAX_PRIOR_SDS, Cause

NAMES = {
    "apogee": "apogee",
    "top_speed": "top speed",
    "peak_accel": "peak acceleration",
    "coast_to_apogee": "coast to apogee",
    "apogee_to_eject": "apogee to ejection",
}


def page(study: Study) -> str:
    """The page."""
    return "\n".join(line for part in (_head, _parts, _steps, _remains, _pair) for line in part(study)) + "\n"


def _head(study: Study) -> Iterator[str]:
    stated = study.report.published["stated"]
    yield "# The reference flights: sources of the published bias"
    yield ""
    yield _text(
        f"A paper inferred drag (Cd) and thrust (alpha) of a small rocket from the apogees of twelve flights, eight of "
        f"them valid. The apogees rebuilt from these values are {stated['bias_m']} m too high on average, all in one "
        "direction. This page breaks the bias down by cause and shows what remains after the corrections. "
        "`fieldkit study reference` computes every figure and writes this page; a test compares the two."
    )
    yield ""


def _parts(study: Study) -> Iterator[str]:
    profile = study.report.thrust_profile
    yield "## The bias in parts"
    yield ""
    yield _text(
        "The exact posterior of Cd and alpha, without a network, is computed with one change to the physics after "
        "another. The part of a step is the change in the mean error that it causes. The published thrust profile "
        "delivers "
        + _list(
            [
                f"{m['delivered_ns']:.1f} N s for the {m['motor']}, certified at {m['certified_ns']:.1f} "
                f"({m['delivered_ns'] / m['certified_ns'] - 1:+.0%})"
                for m in profile["motors"]
            ]
        )
        + f". With it, {study.steps[0].below} of the {len(study.flights)} valid flights are below the lowest apogee "
        "that the prior allows (most drag, least thrust), and no inference can match them."
    )
    yield ""
    total = sum(part.bias for part in study.parts)
    yield from _table(
        ("part", "part of the bias [m]"),
        [(part.title, f"{_signed(part.bias)}") for part in study.parts]
        + [("**published bias**", f"**{_signed(total)}**")],
    )
    yield ""
    three, ejection = sum(part.bias for part in study.parts[:3]), study.ejection
    yield _text(
        f"The excess impulse of the profile causes {three:+.1f} m, the estimator's shrinkage less than a meter. The "
        "missing casing mass, the shape of the thrust curve and the delay in the motor's name hardly change rebuilt "
        "apogees, because Cd and alpha compensate for them; the next table has the effect of each at fixed Cd and "
        f"alpha. With the delay in its name, the F24-4W ejects {abs(ejection.after_apogee):.1f} s "
        f"{'before' if ejection.after_apogee < 0 else 'after'} apogee on these flights, which costs "
        f"{ejection.cost:.1f} m; with a delay a fifth shorter, as certification allows, it would cost "
        f"{ejection.cost_short:.1f} m."
    )
    yield ""


def _steps(study: Study) -> Iterator[str]:
    yield "## Errors before and after, step by step"
    yield ""
    yield _text(
        "Each row includes the corrections of the rows above it. *Rebuilt*: apogees from the Cd and alpha inferred "
        "from the same apogees. *Left out*: from Cd and alpha averaged over the other flights on the same motor, a "
        "true forecast. In parentheses: 90% bootstrap intervals over the flights. *Lower by*: the effect of the step "
        "alone on apogees with the published Cd and alpha."
    )
    yield ""
    rows = []
    for one, lowered in zip(study.steps, study.lowered, strict=True):
        rebuilt, left_out = (values - study.flights.apogee for values in (one.rebuilt, one.left_out))
        rows.append(
            (
                one.world.title,
                _with(rebuilt, sign=True),
                f"{errors(one.left_out, study.flights.apogee)['rmse_m']:.1f}",
                _with(left_out, absolute=True),
                _with(left_out, sign=True),
                str(one.below),
                f"{lowered:.1f}",
            )
        )
    headers = ("physics", "rebuilt: bias", "left out: RMSE", "MAE", "bias", "below the prior's reach", "lower by")
    yield from _table(headers, rows)
    yield ""
    yield _text(
        "In meters. The bias of the rebuilt apogees disappears, but true forecasts improve less: rebuilding an apogee "
        "from itself is a weak test of a forecast of the next flight."
    )
    yield ""
    yield from _table(
        ("each valid flight forecast from the others", "MAE [m]", "standard error", "bias [m]", "flights"),
        [
            (
                rule["title"],
                f"{rule['mae_m']:.1f}",
                f"{rule['standard_error_m']:.1f}",
                f"{rule['bias_m']:+.1f}",
                str(rule["n"]),
            )
            for rule in study.report.rules
        ],
    )
    yield ""


def _remains(study: Study) -> Iterator[str]:
    scatter, loop = study.report.scatter, study.loop
    before = study.left_out
    yield "## What remains"
    yield ""
    yield _text(
        f"Flights on one motor in one configuration scatter by {scatter['sd_m']:.1f} m "
        f"({scatter['degrees_of_freedom']} degrees of freedom), so even a forecast that knew their mean would miss by "
        f"{scatter['perfect_mae_m']:.1f} m. `fieldkit loop`, which starts from certified curves, has the verdict "
        f"*{loop.effect}* for these flights: {loop.why}. The mean error of its leave-one-out forecasts is "
        f"{before.score.mae:.1f} m ({before.mae[0]:.1f} to {before.mae[1]:.1f}) with a bias of "
        f"{before.score.bias:+.1f} m, and {before.score.coverage90:.0%} of the flights are in the 90% "
        f"interval{_after(study)}. The evidence for each effect, from the apogees alone (log Bayes factor against no "
        "effect, not corrected for the number of effects tried):"
    )
    yield ""
    items = [item for item in loop.ranking if item.effect]
    yield from _table(
        ("effect", "log Bayes factor", "left-out MAE with it [m]"),
        [(str(item.best.candidate.place), f"{item.log_bayes:+.1f}", f"{item.score.mae:.1f}") for item in items],
    )
    yield ""


def _after(study: Study) -> str:
    """The result with the loop repeated without each flight."""
    after = study.left_out_after
    if not study.loop.accepted:
        return ""
    return (
        f"; with the effects chosen without each flight it is {after.score.mae:.1f} m ({after.mae[0]:.1f} to "
        f"{after.mae[1]:.1f}), with {after.score.coverage90:.0%} in the interval, which with {after.flights} flights "
        "and one readout each is only a hint"
    )


def _pair(study: Study) -> Iterator[str]:
    pair = study.pair
    gains = [f"{gain:.0f} m at alpha {alpha:.1f}" for alpha, gain in pair.expected_gain.items()]
    yield "## The two E35 flights"
    yield ""
    yield _text(
        f"On the E35-5W, the rocket that was {pair.lighter_by * 1e3:.0f} g lighter flew only {pair.flown_gain:.0f} m "
        f"higher. A simulation of vertical flight gains {_list(gains)}, with the drag at which the heavier "
        "rocket reaches its apogee. The table has, for each effect, the strength that would explain this on the "
        "lighter flight alone at certified thrust; its distance from the prior mean in standard deviations of the "
        "prior; and the readouts that the altimeter would then have shown:"
    )
    yield ""
    headers = ("effect", "strength", "unit", "away [sd]", "top speed [m/s]", "peak [m/s²]", "coast [s]", "ejection [s]")
    yield from _table(headers, [_cause(cause) for cause in pair.causes if cause.possible])
    yield ""
    impossible = [cause.effect for cause in pair.causes if not cause.possible]
    likely = [cause for cause in pair.causes if cause.possible and cause.away < MAX_PRIOR_SDS]
    yield _text(
        f"No strength within bounds explains it for {_list(impossible)}. Within {MAX_PRIOR_SDS} standard deviations "
        f"are {_list([cause.effect for cause in likely])}. The apogee cannot distinguish these, because it is the "
        "same for all of them; other readouts of the altimeter can. Pairs of these effects that one more such flight "
        "would distinguish by two standard deviations of the scatter of single flights:"
    )
    yield ""
    yield from _table(
        ("recorded", "pairs distinguished"),
        [(NAMES.get(one.readout, one.readout), f"{one.distinguished} of {one.pairs}") for one in pair.discriminations],
    )
    yield ""
    advice = [f"{cause.effect}: {effects()[cause.effect].tell_apart}" for cause in likely if cause.effect in effects()]
    best = max(pair.discriminations[:-1], key=lambda one: one.distinguished)
    yield _text(
        f"So on the next flight of configuration A on the E35-5W, record {NAMES[best.readout]} first, and if possible "
        f"all five readouts. In addition, {'; '.join(advice)}."
    )


def _cause(cause: Cause) -> Sequence[str]:
    shows = cause.shows
    return (
        cause.effect,
        f"{cause.strength:.2f}",
        cause.unit,
        f"{cause.away:.1f}",
        f"{shows['top_speed']:.0f}",
        f"{shows['peak_accel']:.0f}",
        f"{shows['coast_to_apogee']:.1f}",
        f"{shows['apogee_to_eject']:+.1f}",
    )


def _with(misses: np.ndarray, *, absolute: bool = False, sign: bool = False) -> str:
    value = np.abs(misses).mean() if absolute else misses.mean()
    low, high = interval(misses, absolute)
    form = "+.1f" if sign else ".1f"
    return f"{value:{form}} ({low:{form}} to {high:{form}})"


def _signed(value: float) -> str:
    return f"{value:+.1f}" if abs(value) >= 0.05 else f"{value:+.2f}"


def _table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(headers)} |"
    yield f"|{'---|' * len(headers)}"
    for row in rows:
        yield f"| {' | '.join(row)} |"


def _list(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)


def _text(words: str) -> str:
    return fill(words, 118, break_long_words=False, break_on_hyphens=False)
