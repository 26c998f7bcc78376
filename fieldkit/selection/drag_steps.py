"""Drag that switches within the coast of some flights of a rocket: which ones, from when to when, and by how much.

Every flight has the rocket's own drag area B, apart from the scatter of flights and the errors of its log. In a member
flight it is B (1 + a) from one time to another, which may be before the first and after the last interval of the coast.
B, the mean of a over the members, the fraction of flights that are members and the error of the static ports are
shared. The likelihood of each log (`fieldkit.analysis.force_profile`) is normal in B, B a and the error of the ports,
so a is integrated out in closed form for every pair of times, and the shared figures on a grid. A flight may also have
a lone step of any size, with a small probability: what one flight alone shows is not a property of the rocket.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.force_profile import SWITCH_TIMES, DragLikelihood, DragProfile, ramp_matrix, step_sums
from fieldkit.shapes import Array, Float, Int, Integers

_LEVEL_RANGE, _LEVEL_STEP, _LEVEL_SD = (-1.1, 0.6), 0.05, 0.3
"""Grid of the logarithm of the rocket's own drag around the median of the logs', and its prior standard deviation.
[1]"""
_PORTS = (-1.6, -0.8, 0.0, 0.8, 1.6)
"""Grid of the error of the static ports that the flights of a rocket share, in prior standard deviations. [1]"""
_EDGES, _SETTINGS = 28, 2
"""Most edges between which the shared figures are determined, and noise settings of a log. [1]"""
_MEANS = np.exp(np.linspace(np.log(0.25), np.log(4.0), 15))
"""Grid of the mean relative increase of drag: from what a log can just show to fully open brakes. [1]"""
_DECREASES = -np.exp(np.linspace(np.log(0.25), np.log(0.6), 5))
"""The same for a decrease. [1]"""
_INCREASE_PROBABILITY = 0.95
"""Probability that drag that switches increases. [1]"""
SIZE_SD = 0.35
"""Standard deviation of single steps around the mean, as a fraction of it: brakes that open partly. [1]"""
_FRACTIONS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Grid of the fraction of flights with a step. [1]"""
_FROM_START, _TO_END = 0.1, 0.4
"""Probability that a step begins before the coast is seen, and that it lasts to its end. [1]"""
_SHORTEST, _SHORTEST_PULSE = 0.6, 0.15
"""Shortest step of a member and shortest lone one: a shock, or a sensor that was disturbed. [s]"""
_EARLIEST = 0.4
"""How long after the start of a coast its first step begins, unless it lasts from before: fading thrust and pitching
look like one there. [s]"""
_SLOWEST_ONSET = 0.35
"""Speed at which the last step begins, as a fraction of the first speed: drag is then an eighth of what it was. [1]"""
PULSE_PROBABILITY, LONE_PROBABILITY, LONE_SD = 0.05, 0.005, 1.0
"""Probabilities of a short and of a long lone step of a flight that is no member, and its standard deviation. [1]"""
_MOST_PARTS = 3
"""Most steps in one flight. [1]"""
_ANOTHER_PROBABILITY = 0.2
"""Probability that a flight with steps has one more. [1]"""
_LEAST_SHOWN = 0.05
"""Smallest probability of steps that are reported. [1]"""
_MAX_STEPS_SHOWN = 40
"""Number of the most probable pairs of times that are averaged for drag along the coast. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class LoggedDrag:
    """The drag profile of one flight, and its drag area per unit of relative drag [m^2].

    `scatter` is the standard deviation of its drag area around the rocket's, relative to it [1].
    """

    flight_id: str
    profile: DragProfile
    unit: float
    scatter: float


@dataclass(frozen=True, slots=True)
class DragStep:
    """Drag that switched in a coast: times from lift-off [s], None to the end of what the log shows; the ratio to the
    drag without it, its standard deviation, and its probability."""

    begin: float
    end: float | None
    ratio: float
    sd: float
    probability: float


@dataclass(frozen=True, slots=True, eq=False)
class FlightDrag:
    """Drag of one flight along its coast relative to the rocket's own, with standard deviations, and its steps.

    `member` is the probability that it has a step [1]: `shared` if drag switches on some flights of the rocket, and
    `lone` if not, so that the step is its own. `mean` is its expected mean drag over the coast relative to the rocket's
    own, weighted by what it takes from the speed [1].
    """

    flight_id: str
    time_from_liftoff: Float[Array, "interval"]
    ratio: Float[Array, "interval"]
    sd: Float[Array, "interval"]
    steps: tuple[DragStep, ...]
    member: float
    shared: float
    lone: float
    mean: float
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class DragSteps:
    """What the logs of a rocket show of drag that switches.

    `log_bayes` is the log evidence of the coasts for it [nat], `present` its probability by the logs alone [1]. `own`
    is the rocket's own drag area [m^2], `own_sd` its relative standard deviation; `size` is the relative increase by a
    step, with its standard deviation; `fraction` that of the flights with a step.
    """

    log_bayes: float
    present: float
    own: float
    own_sd: float
    size: float
    size_sd: float
    fraction: float
    flights: tuple[FlightDrag, ...]
    ports: float = 0.0
    """Error of the static ports that the flights share, in prior standard deviations. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class PossibleSteps:
    """The steps a log may have: edges, log prior of long and of short ones, and sums over them by noise setting."""

    first: Int[Integers, "step"]
    last: Int[Integers, "step"]
    log_prior: Float[Array, "step"]
    log_prior_short: Float[Array, "step"]
    parts: "tuple[_Part, ...]"


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One noise setting and duration of a switch: log weight, the matrix that turns steps into ramps, and the products
    of `step_sums` for the steps and for a constant."""

    log_weight: float
    likelihood: DragLikelihood
    ramp: Float[Array, "interval interval"]
    both: Float[Array, "step"]
    joint: Float[Array, "step"]
    pushed: Float[Array, "step"]
    level: float
    shift: float


def drag_steps(logs: Sequence[LoggedDrag], log_prior_odds: float) -> DragSteps | None:
    """Drag that switches within the coasts of these logs, with its prior odds [nat]; None without any."""
    if not logs:
        return None
    units = np.array([one.unit for one in logs])
    means = np.concatenate([_DECREASES, _MEANS])
    log_means = np.concatenate(
        [
            np.full(_DECREASES.size, np.log((1 - _INCREASE_PROBABILITY) / _DECREASES.size)),
            np.full(_MEANS.size, np.log(_INCREASE_PROBABILITY / _MEANS.size)),
        ]
    )
    ports = _port_errors(logs)
    by_ports = [[possible_steps(given_ports(one, error)) for error in ports.tolist()] for one in logs]
    levels, log_levels = _levels(units, [steps[ports.size // 2] for steps in by_ports])
    log_levels = log_levels[:, None] - 0.5 * ports**2 - np.logaddexp.reduce(-0.5 * ports**2)
    every = [_log_likelihoods(steps, levels / unit, means) for steps, unit in zip(by_ports, units, strict=True)]
    none, pulse, lone, some = (
        np.stack(part).reshape(len(logs), log_levels.size, *part[0].shape[2:]) for part in zip(*every, strict=True)
    )
    plain, log_levels = _plain(none, pulse, lone), log_levels.ravel()
    fractions = np.array(_FRACTIONS)
    mixed = np.logaddexp(
        np.log1p(-fractions) + plain[..., None, None], np.log(fractions) + some[..., None]
    )  # flight, level, mean, fraction
    joint = mixed.sum(axis=0) + log_levels[:, None, None] + log_means[:, None] - np.log(fractions.size)
    alone = plain.sum(axis=0) + log_levels
    log_bayes = float(np.logaddexp.reduce(joint, axis=None) - np.logaddexp.reduce(alone))
    present = float(1 / (1 + np.exp(-np.clip(log_bayes + log_prior_odds, -500, 500))))
    weight = np.exp(joint - np.logaddexp.reduce(joint, axis=None))
    weight_alone = np.exp(alone - np.logaddexp.reduce(alone))
    by_level, by_mean = weight.sum(axis=(1, 2)), weight.sum(axis=(0, 2))
    both = (present * by_level + (1 - present) * weight_alone).reshape(levels.size, ports.size)
    by_level, error = both.sum(axis=1), float(both.sum(axis=0) @ ports)
    own = float(by_level @ levels)
    own_sd = float(np.sqrt(by_level @ (levels - own) ** 2)) / own
    size = float(by_mean @ means)
    size_sd = float(np.sqrt(by_mean @ (means - size) ** 2))
    shared = np.einsum("flmp,lmp->f", np.exp(np.log(fractions) + some[..., None] - mixed), weight)
    lones = np.exp(np.log(LONE_PROBABILITY) + lone - plain) @ weight_alone
    flights = []
    for log, common, single in zip(logs, shared.tolist(), lones.tolist(), strict=True):
        parts = present * common, (1 - present) * single
        sizes = (size, float(np.hypot(size_sd, SIZE_SD * abs(size)))) if parts[0] > parts[1] else (0.0, LONE_SD)
        shown = _flight(given_ports(log, error), sum(parts), own, own_sd, sizes)
        flights.append(replace(shown, shared=common, lone=single))
    fraction = float(weight.sum(axis=(0, 1)) @ fractions)
    return DragSteps(log_bayes, present, own, own_sd, size, size_sd, fraction, tuple(flights), error)


def _port_errors(logs: Sequence[LoggedDrag]) -> Float[Array, "error"]:
    """The errors of the rocket's static ports that are tried; none if no height depends on them."""
    some = any(one.ports.precision for log in logs for one in log.profile.likelihoods)
    return np.array(_PORTS if some else (0.0,))


def given_ports(log: LoggedDrag, error: float) -> LoggedDrag:
    """A log, given the error of the static ports in prior standard deviations [1]."""
    likelihoods = tuple(one.with_ports(error) for one in log.profile.likelihoods)
    return replace(log, profile=replace(log.profile, likelihoods=likelihoods))


def possible_steps(log: LoggedDrag, most_edges: int = _EDGES) -> PossibleSteps:
    """The steps that a log may have, from one of some edges of its intervals to a later one."""
    profile = log.profile
    count = profile.speed.size
    edges = np.unique(np.linspace(0, count, min(count, most_edges) + 1).round().astype(int))
    first, last = (edges[rows] for rows in np.triu_indices(edges.size, 1))
    early = np.append(profile.speed, 0.0)[first] > _SLOWEST_ONSET * profile.speed[0]
    resolved = (first == 0) | (first * profile.length >= _EARLIEST)
    kept = early & resolved & ((last - first) * profile.length >= _SHORTEST_PULSE)
    first, last = first[kept], last[kept]
    inner = max(edges.size - 2, 1)
    begins = np.where(first == 0, _FROM_START, (1 - _FROM_START) / inner)
    later = np.maximum((edges[None, :] > first[:, None]).sum(axis=1) - 1, 1)
    ends = np.where(last == count, _TO_END, (1 - _TO_END) / later)
    log_prior = np.log(begins * ends)
    log_prior -= np.logaddexp.reduce(log_prior)
    long = ((last - first) * profile.length >= _SHORTEST) | (last == count)
    log_prior_long, log_prior_short = (np.where(part, log_prior, -np.inf) for part in (long, ~long))
    log_prior_long -= np.logaddexp.reduce(log_prior_long)
    log_prior_short -= np.logaddexp.reduce(log_prior_short)
    parts = []
    for one in profile.likelihoods[:_SETTINGS]:
        widened = with_scatter(one, log.scatter)
        level, shift = float(widened.precision.sum()), float(widened.shift.sum())
        for lasts in SWITCH_TIMES:
            ramp = ramp_matrix(count, lasts / profile.length)
            sums = step_sums(ramp.T @ widened.precision @ ramp, ramp.T @ widened.shift)
            both, joint, pushed = (table[first, last] for table in sums)
            log_weight = widened.log_weight - float(np.log(len(SWITCH_TIMES)))
            parts.append(_Part(log_weight, widened, ramp, both, joint, pushed, level, shift))
    return PossibleSteps(first, last, log_prior_long, log_prior_short, tuple(parts))


def with_scatter(one: DragLikelihood, scatter: float) -> DragLikelihood:
    """The likelihood with the scatter of a flight's level [1] integrated out (Sherman and Morrison)."""
    row, push = one.precision.sum(axis=0), float(one.shift.sum())
    factor = scatter**2 / (1 + scatter**2 * row.sum())
    add = 0.5 * (factor * push**2 - float(np.log1p(scatter**2 * row.sum())))
    precision = one.precision - factor * np.outer(row, row)
    shift = one.shift - factor * row * one.shift.sum()
    return replace(one, log_weight=one.log_weight + add, precision=precision, shift=shift, prior=one.prior + scatter**2)


def _levels(
    units: Float[Array, "flight"], steps: Sequence[PossibleSteps]
) -> tuple[Float[Array, "level"], Float[Array, "level"]]:
    """A grid of the rocket's own drag [m^2] around the levels of the logs, and its log prior."""
    own = [unit * one.parts[0].shift / one.parts[0].level for unit, one in zip(units, steps, strict=True)]
    middle = float(np.log(np.median(np.maximum(own, 0.05 * units))))
    grid = np.arange(*_LEVEL_RANGE, _LEVEL_STEP)
    log_prior = -0.5 * (grid / _LEVEL_SD) ** 2
    return np.exp(middle + grid), log_prior - np.logaddexp.reduce(log_prior)


def _log_likelihoods(
    by_ports: Sequence[PossibleSteps], levels: Float[Array, "level"], means: Float[Array, "mean"]
) -> tuple[
    Float[Array, "level error"],
    Float[Array, "level error"],
    Float[Array, "level error"],
    Float[Array, "level error mean"],
]:
    """Log likelihoods of a log for levels of relative drag and errors of the ports, for each of which `by_ports` has
    the possible steps: without a step, with a short and a long lone one, and with one of each mean size."""
    steps = by_ports[0]
    none: list[Array] = []
    pulse: list[Array] = []
    lone: list[Array] = []
    some: list[Array] = []
    for parts in zip(*(steps.parts for steps in by_ports), strict=True):
        one = parts[0]  # an error of the ports changes no precision
        shift, log_weight = (np.array([getattr(part, name) for part in parts]) for name in ("shift", "log_weight"))
        plain = levels[:, None] * shift - 0.5 * one.level * levels[:, None] ** 2 + log_weight
        none.append(plain)
        at = levels[:, None, None]
        linear, quadratic = at * np.stack([part.pushed for part in parts]) - at**2 * one.joint, at**2 * one.both
        for kind, log_prior in ((pulse, steps.log_prior_short), (lone, steps.log_prior)):
            kind.append(plain + summed_over_steps(linear, quadratic, 0.0, LONE_SD, log_prior))
        each = [summed_over_steps(linear, quadratic, mean, SIZE_SD * abs(mean), steps.log_prior) for mean in means]
        some.append(plain[..., None] + np.stack(each, axis=-1))
    each_none, each_pulse, each_lone, each_some = (
        np.logaddexp.reduce(np.stack(part), axis=0) for part in (none, pulse, lone, some)
    )
    return each_none, each_pulse, each_lone, each_some


def summed_over_steps(
    linear: Float[Array, "*many step"],
    quadratic: Float[Array, "*many_or_one #step"],
    mean: float,
    sd: float,
    log_prior: Float[Array, "step"],
) -> Float[Array, "*many"]:
    """Log of the integral of exp(linear a - quadratic a²/2) over a normal a, summed over steps with their prior; all
    relative [1] and [nat].

    Derivation: the integral of a normal density times the exponential of a quadratic form.
    """
    precision = quadratic * sd**2 + 1
    joint = linear * sd + mean / sd
    joint *= joint
    joint *= 0.5 / precision
    joint += log_prior - 0.5 * ((mean / sd) ** 2 + np.log(precision))
    highest = joint.max(axis=-1, keepdims=True)
    joint -= highest
    return np.asarray(highest[..., 0] + np.log(np.exp(joint, out=joint).sum(axis=-1)))


def _plain(none: Array, pulse: Array, lone: Array) -> Float[Array, "*any"]:
    """Log likelihood without a common step, from those without any, with a short lone one, and with a long one."""
    rest = np.log1p(-PULSE_PROBABILITY - LONE_PROBABILITY) + none
    return np.asarray(np.logaddexp.reduce([rest, np.log(PULSE_PROBABILITY) + pulse, np.log(LONE_PROBABILITY) + lone]))


def _flight(log: LoggedDrag, member: float, own: float, own_sd: float, sizes: tuple[float, float]) -> FlightDrag:
    """Drag along a flight and its steps, given the rocket's own drag, and the mean size of steps and its spread."""
    level, (size, spread) = own / log.unit, sizes
    fine = possible_steps(log, log.profile.speed.size)
    count, weights, means, variances = log.profile.speed.size, [], [], []
    chance = _chances(fine, level, size, spread)
    healthy = np.array([one.log_weight + one.shift * level - 0.5 * one.level * level**2 for one, *_ in chance])
    healthy = np.exp(healthy - np.logaddexp.reduce(healthy))
    for (one, by_step, amplitude, precision), plain in zip(chance, healthy.tolist(), strict=True):
        given = one.likelihood
        means.append(given.given(np.full(count, level)))
        variances.append(given.variance)
        weights.append((1 - member) * plain)
        for row in np.argsort(-by_step)[:_MAX_STEPS_SHOWN].tolist():
            shape = one.ramp @ _shape(fine, row, count)
            means.append(given.given(level * (1 + amplitude[row] * shape)))
            variances.append(given.variance + (level * shape * spread) ** 2 / precision[row])
            weights.append(member * by_step[row])
    weight = np.array(weights) / np.sum(weights)
    whole = weight @ np.stack(means)
    variance = weight @ (np.stack(variances) + (np.stack(means) - whole) ** 2)
    ratio = whole / level
    sd = np.hypot(np.sqrt(variance) / level, own_sd * ratio)
    taken = log.profile.speed**2
    steps = _found(log.profile, fine, level, size, spread, member) if member > _LEAST_SHOWN else ()
    mean = float(taken @ ratio / taken.sum())
    time, source = log.profile.time_from_liftoff, log.profile.source
    return FlightDrag(log.flight_id, time, ratio, sd, steps, member, member, 0.0, mean, source)


def _shape(steps: PossibleSteps, row: int, count: int) -> Float[Array, "interval"]:
    shape = np.zeros(count)
    shape[steps.first[row] : steps.last[row]] = 1.0
    return shape


def _chances(
    steps: PossibleSteps, level: float, size: float, spread: float
) -> "list[tuple[_Part, Array, Array, Array]]":
    """For each noise setting: the probability of each step given that there is one, the mean of its relative size, and
    the factor by which the log narrows that."""
    found = []
    for one in steps.parts:
        linear, quadratic = level * one.pushed - level**2 * one.joint, level**2 * one.both
        precision = quadratic * spread**2 + 1
        log = 0.5 * ((linear * spread + size / spread) ** 2 / precision - (size / spread) ** 2 - np.log(precision))
        plain = -0.5 * one.level * level**2 + one.shift * level + one.log_weight
        found.append((one, log + plain + steps.log_prior, (linear * spread**2 + size) / precision, precision))
    total = np.logaddexp.reduce([np.logaddexp.reduce(log) for _, log, _, _ in found])
    return [(one, np.exp(log - total), amplitude, precision) for one, log, amplitude, precision in found]


def _found(
    profile: DragProfile, steps: PossibleSteps, level: float, size: float, spread: float, member: float
) -> tuple[DragStep, ...]:
    """The steps of a member flight: the most probable one, and others while they are more probable than not."""
    count, edges = profile.speed.size, profile.edges
    one, chance, amplitude, precision = max(_chances(steps, level, size, spread), key=lambda part: float(part[1].sum()))
    taken = np.zeros(count)
    found: list[DragStep] = []
    probability = member
    while len(found) < _MOST_PARTS:
        row = int(np.argmax(chance))
        first, last = (int(_middle(place, chance)) for place in (steps.first, steps.last))
        if not first < last:
            first, last = int(steps.first[row]), int(steps.last[row])
        own = float(amplitude[row])
        found.append(
            DragStep(
                float(edges[first]),
                None if last == count else float(edges[last]),
                1 + own,
                spread / float(np.sqrt(precision[row])),
                probability,
            )
        )
        taken[steps.first[row] : steps.last[row]] = own
        spent = np.concatenate(([0.0], np.cumsum(one.ramp.T @ (one.likelihood.precision @ (one.ramp @ taken)))))
        offset = spent[steps.last] - spent[steps.first]
        free = np.concatenate(([0.0], np.cumsum(taken != 0)))
        margin = max(1, round(_SHORTEST / profile.length))
        separate = free[np.minimum(steps.last + margin, count)] == free[np.maximum(steps.first - margin, 0)]
        linear = level * one.pushed - level**2 * (one.joint + offset)
        precision = level**2 * one.both * spread**2 + 1
        gain = 0.5 * ((linear * spread + size / spread) ** 2 / precision - (size / spread) ** 2 - np.log(precision))
        gain = np.where(separate, gain + steps.log_prior, -np.inf)
        odds = float(np.logaddexp.reduce(gain)) + np.log(_ANOTHER_PROBABILITY / (1 - _ANOTHER_PROBABILITY))
        if not odds > 0:
            break
        chance = np.exp(gain - np.logaddexp.reduce(gain))
        amplitude = (linear * spread**2 + size) / precision
        probability = member / (1 + float(np.exp(-odds)))
    return tuple(sorted(found, key=lambda step: step.begin))


def _middle(place: Int[Integers, "step"], chance: Float[Array, "step"]) -> float:
    """The median of a place over steps. [1]"""
    order = np.argsort(place, kind="stable")
    total = np.cumsum(chance[order])
    return float(place[order][np.searchsorted(total, total[-1] / 2)])
