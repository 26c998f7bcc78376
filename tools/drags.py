"""Print the drag of the coast by both sensors of the recordings next to the checkout: python -m tools.drags

For each flight with an accelerometer: the drag that it shows, the one from the heights alone, and the logarithm of
their ratio. Below is the standard deviation of that logarithm beyond those of the two: the posterior mode with the
Student-t distribution of the model's readouts, and the prior of static ports with the weight that `fieldkit learn`
gives to priors. A flight in two files counts once. `coast_drag.ports` of the hyperprior is that.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import t as student

from fieldkit.analysis import measure
from fieldkit.analysis.drag_and_impulse import PORT_ERROR, PORTS_SD
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.inference.laplace.learning import PRIOR_GROUPS
from fieldkit.model.hyperprior import START
from tests.analysis.test_real_logs import FLIGHTS, LOGS, flown

FELT = ("acceleration", "felt", "felt_total", "inertial_altitude", "inertial_speed")
"""Channels that come from an accelerometer."""


def main() -> int:
    """Print the table; 1 if there are no recordings."""
    if not LOGS.is_dir():
        print(f"no recordings in {LOGS}")
        return 1
    print("| recording | accelerometer [1/m] | heights [1/m] | log ratio |\n|---|---|---|---|")
    pairs: dict[str, list[tuple[float, float]]] = {}
    for name in FLIGHTS:
        reading, recorded = flown(name)
        felt = recorded.figures.get("coast_drag")
        if felt is None or "acceleration" not in felt.source:
            continue
        alone = measure(tuple(replace(one, **dict.fromkeys(FELT)) for one in reading.clocks), reading.events)
        seen = alone.figures.get("coast_drag")
        if seen is None:
            print(f"| {name} | {felt.value:.5f} ± {felt.sd:.5f} | | |")
            continue
        ratio, sd = float(np.log(seen.value / felt.value)), float(np.hypot(seen.sd / seen.value, felt.sd / felt.value))
        pairs.setdefault(name.split("__")[1].split("_")[0], []).append((ratio, sd))
        print(f"| {name} | {felt.value:.5f} ± {felt.sd:.5f} | {seen.value:.5f} ± {seen.sd:.5f} | {ratio:+.2f} |")
    print(f"standard deviation from {len(pairs)} flights: {_ports_sd(pairs):.2f}; used: {PORTS_SD}")
    return 0


def _ports_sd(pairs: Mapping[str, Sequence[tuple[float, float]]]) -> float:
    """The posterior mode from log ratios and their known standard deviations, by flight."""
    ratios, sds = np.array([np.mean(one, axis=0) for one in pairs.values()]).T

    def cost(extra: float) -> float:
        scale = np.hypot(sds, extra)
        prior = PRIOR_GROUPS * (np.log(extra) + (PORT_ERROR * STATIC_SD / extra) ** 2 / 2)
        return float(prior + np.log(scale).sum() - student.logpdf(ratios / scale, START.tail).sum())

    return float(minimize_scalar(cost, bounds=(0.01, 1.0), method="bounded").x)


if __name__ == "__main__":
    sys.exit(main())
