"""The reference study as a page of Markdown; every figure in it is computed."""

from collections.abc import Iterator, Sequence
from textwrap import fill

import numpy as np

from fieldkit.physics.effect import effects
from studies.paper.reference import errors
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
    yield "# The reference flights: where the published bias comes from, and what remains"
    yield ""
    yield _text(
        f"A paper inferred drag (Cd) and thrust (alpha) of a small rocket from the apogees of twelve flights, of which "
        f"eight are valid, and rebuilt those apogees {stated['bias_m']} m too high in the mean, all to one side. "
        "This page "
        "traces that bias in parts and says what is left when they are corrected. `fieldkit study reference` "
        "computes every "
        "figure here and writes the page; a test compares the two."
    )
    yield ""


def _parts(study: Study) -> Iterator[str]:
    profile = study.report.thrust_profile
    yield "## The bias in parts"
    yield ""
    yield _text(
        "The exact posterior of Cd and alpha, with no network in it, is taken through one physics after the other. The "
        "difference that a step makes to the mean error is its share. The thrust profile that was published delivers "
        + _list(
            [
                f"{m['delivered_ns']:.1f} N s for the {m['motor']} where {m['certified_ns']:.1f} are certified "
                f"({m['delivered_ns'] / m['certified_ns'] - 1:+.0%})"
                for m in profile["motors"]
            ]
        )
        + f". {study.steps[0].below} of the {len(study.flights)} valid flights then lie below the lowest apogee that "
        "the "
        "prior can make (most drag, least thrust), and no inference can reach them."
    )
    yield ""
    total = sum(part.share for part in study.parts)
    yield from _table(
        ("part", "part of the bias [m]"),
        [(part.title, f"{_signed(part.share)}") for part in study.parts]
        + [("**published bias**", f"**{_signed(total)}**")],
    )
    yield ""
    three, ejection = sum(part.share for part in study.parts[:3]), study.ejection
    yield _text(
        f"The over-delivering profile is worth {three:+.1f} m. The estimator's shrinkage is under a meter. What is "
        "missing "
        "from the mass, the shape of the thrust curve and the delay in the motor's name hardly move apogees that are "
        "rebuilt from themselves, because Cd and alpha give way; what each does to a flight at fixed Cd and alpha "
        "stands "
        f"in the next table. By its name the F24-4W ejects {abs(ejection.after_apogee):.1f} s "
        f"{'before' if ejection.after_apogee < 0 else 'after'} apogee on these flights, which costs "
        f"{ejection.cost:.1f} m; with "
        f"a delay a fifth shorter, as certificates allow, it would cost {ejection.cost_short:.1f} m."
    )
    yield ""


def _steps(study: Study) -> Iterator[str]:
    yield "## Errors before and after, step by step"
    yield ""
    yield _text(
        "Each row keeps the corrections of the rows above it. *Rebuilt*: apogees from the Cd and alpha inferred from "
        "those apogees. *Left out*: Cd and alpha averaged over the same motor's other flights, the honest forecast. In "
        "brackets: 90% intervals over the flights (bootstrap). *Lower by*: what the step alone does to the apogees of "
        "the published Cd and alpha."
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
        "In meters. The bias of the rebuilt apogees goes, and honest forecasts get better by less: rebuilding an "
        "apogee "
        "from itself says little about the next flight."
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
        f"Flights of one motor and configuration scatter by {scatter['sd_m']:.1f} m "
        f"({scatter['degrees_of_freedom']} degrees "
        f"of freedom), so a forecast that knew their mean would still miss by {scatter['perfect_mae_m']:.1f} m. "
        f"`fieldkit loop`, which starts from certified curves, says *{loop.effect}* on these flights: "
        f"{loop.why}. It forecasts flights left out to {before.score.mae:.1f} m "
        f"({before.mae[0]:.1f} to {before.mae[1]:.1f}), bias {before.score.bias:+.1f} m, with "
        f"{before.score.coverage90:.0%} of them in the 90% interval{_after(study)}. Its evidence for each effect, the "
        "apogees alone to go by (log Bayes factor against no effect, to be paid for by the number tried):"
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
        f", and to {after.score.mae:.1f} m ({after.mae[0]:.1f} to {after.mae[1]:.1f}), "
        f"{after.score.coverage90:.0%} in the interval, with what the choice made without each of them adds: with "
        f"{after.flights} flights and one readout of each, no more than a hint"
    )


def _pair(study: Study) -> Iterator[str]:
    pair = study.pair
    gains = [f"{gain:.0f} m at alpha {alpha:.1f}" for alpha, gain in pair.expected_gain.items()]
    yield "## The two E35 flights"
    yield ""
    yield _text(
        f"On the E35-5W the rocket {pair.lighter_by * 1e3:.0f} g lighter flew {pair.flown_gain:.0f} m higher. "
        "Straight flight "
        f"expects {_list(gains)}, with the drag that lets the heavier rocket reach its apogee. For each effect, "
        "what it "
        "would take on the lighter flight alone, at certified thrust; how far that is from what is believed of it, in "
        "standard deviations of its prior; and what the altimeter would then have shown:"
    )
    yield ""
    headers = ("effect", "strength", "unit", "away [sd]", "top speed [m/s]", "peak [m/s²]", "coast [s]", "ejection [s]")
    yield from _table(headers, [_cause(cause) for cause in pair.causes if cause.possible])
    yield ""
    impossible = [cause.effect for cause in pair.causes if not cause.possible]
    likely = [cause for cause in pair.causes if cause.possible and cause.away < MAX_PRIOR_SDS]
    yield _text(
        f"No strength within its bounds does it: {_list(impossible)}. Within {MAX_PRIOR_SDS} standard deviations lie "
        f"{_list([cause.effect for cause in likely])}. The apogee cannot distinguish these, being the same in all "
        "of them; "
        "the readouts that the altimeter also shows can. Pairs of the likely ones that one more such flight would "
        "distinguish, by two standard deviations of single flights:"
    )
    yield ""
    yield from _table(
        ("recorded", "pairs distinguished"),
        [
            (NAMES.get(on_progress.readout, on_progress.readout), f"{on_progress.apart} of {on_progress.pairs}")
            for on_progress in pair.tells
        ],
    )
    yield ""
    advice = [f"{cause.effect}: {effects()[cause.effect].tell_apart}" for cause in likely if cause.effect in effects()]
    best = max(pair.tells[:-1], key=lambda on_progress: on_progress.apart)
    yield _text(
        f"So the next flight of configuration A on the E35-5W should write down {NAMES[best.readout]} first, and "
        "all five "
        f"readouts if it can. Beyond that, {'; '.join(advice)}."
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
