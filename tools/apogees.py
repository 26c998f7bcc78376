"""Print the errors of measured apogees and their times in the recordings next to the checkout: python -m tools.apogees

For each flight: the highest median of eleven samples, the measured apogee and its difference; and, if the samples
determine it, the time of the vertex of the parabola through those medians and the difference of the measured time.
"""

import sys

from tests.analysis.test_real_logs import FLIGHTS, LOGS, flown, robust_apogee


def main() -> int:
    """Print the table; 1 if there are no recordings."""
    if not LOGS.is_dir():
        print(f"no recordings in {LOGS}")
        return 1
    print("| recording | medians [m] | measured [m] | off [m] | off [%] | time off [s] |\n|---|---|---|---|---|---|")
    for name, when in FLIGHTS.items():
        reading, recorded = flown(name)
        right, apogee = robust_apogee(reading.clocks), recorded.figures["apogee"]
        off = apogee.value - right
        cells = f"{right:.1f} | {apogee.value:.1f} ± {apogee.sd:.1f} | {off:+.1f} | {off / right:+.2%}"
        late = "" if when is None else f"{recorded.events['apogee'].time - when:+.2f}"
        print(f"| {name} | {cells} | {late} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
