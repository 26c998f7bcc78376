"""The drag along real coasts: `python -m tools.real_forces LOGS OUT.md`.

LOGS is the folder of recordings with their SOURCES.md, and a folder `brakes` of flights with air brakes if it is there.
For each recording: its drag by all sensors and by the heights alone, and whether it switches. For the flights with
brakes: the drag that the loop finds, and the errors of the apogee with the state of the brakes known and unknown.
"""

import argparse
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.analysis import columns, measure
from fieldkit.analysis.force_profile import DragProfile, drag_profile
from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight, Series
from fieldkit.importing import Reading
from fieldkit.importing.read import read_recordings
from fieldkit.importing.reading import ColumnChoice
from fieldkit.physics.history import history_of
from fieldkit.selection.drag_steps import LoggedDrag, drag_steps
from fieldkit.selection.logged_forces import DRAG_STEP, FlightLog, flight_log
from fieldkit.selection.prior import log_prior_odds
from tools.drags import FELT
from tools.markdown import prose, table

SCATTER = 0.03
"""Standard deviation of the drag of single flights. [1]"""
MASSES = {"12_23": 0.588, "2_7": 0.594, "2_15": 0.551, "2_26": 0.551}
"""Dry mass of the contest rocket by the date in a file's name. [kg]"""
VERTICAL = ColumnChoice({"acceleration": "vertical acceleration (m/s^2)"})
PARTS = 6
"""Number of parts of a coast in a row of the table. [1]"""


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", type=Path)
    parser.add_argument("out", type=Path)
    arguments = parser.parse_args()
    lines = [*HEAD, *table(HEADERS, recordings(arguments.logs))]
    if (arguments.logs / "brakes").is_dir():
        lines += brakes(arguments.logs / "brakes")
    arguments.out.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


HEAD = [
    "# Drag along real coasts",
    "",
    *prose(
        "The drag of a coast is b = rho Cd A / 2m, which needs neither mass nor size ([the loop](loop.md) compares it",
        "with the rocket's other flights). The table has b of published recordings as if it were constant, by all",
        "sensors and by the heights alone, each with its standard deviation, and how far the two are apart in standard",
        "deviations of their difference. `top_shot` and `juno3` are single flights on two loggers. The last column is",
        "the probability of a step, if the flight is judged alone.",
    ),
    *prose("`python -m tools.real_forces LOGS docs/real-forces.md` writes this page from a folder of the recordings."),
]
HEADERS = ("recording", "sensors", "b [1/km]", "heights alone [1/km]", "apart", "step")


def recordings(folder: Path) -> Iterator[Sequence[str]]:
    """A row for each recording whose coast shows drag."""
    for path in sorted(folder.iterdir()):
        reading = recorded(path)
        if reading is None:
            continue
        profile = profile_of(reading)
        if profile is None:
            continue
        heights = profile_of(replace(reading, series=tuple(without_accelerometer(reading))))
        (value, sd), alone = profile.level, heights.level if heights is not None else None
        steps = drag_steps([LoggedDrag(path.stem, profile, profile.reference, SCATTER)], log_prior_odds([DRAG_STEP]))
        assert steps is not None
        own = heights is not None and heights.source != profile.source
        gap = abs(value - alone[0]) / np.hypot(sd, alone[1]) if alone and own else None
        yield (
            path.stem,
            profile.source,
            f"{1e3 * value:.2f} ± {1e3 * sd:.2f}",
            f"{1e3 * alone[0]:.2f} ± {1e3 * alone[1]:.2f}" if alone else "",
            f"{gap:.1f}" if gap is not None else "",
            f"{steps.flights[0].member:.0%}",
        )


def recorded(path: Path, choices: Sequence[ColumnChoice] = ()) -> Reading | None:
    """The flight in a log; None if the file is no log of heights over time."""
    try:
        readings = read_recordings(path.read_bytes(), path.name, None, choices)
    except (FieldkitError, IsADirectoryError):
        return None
    return next((one for one in readings if one.describes == "flight"), None)


def without_accelerometer(reading: Reading) -> Iterator[Series]:
    """The channels of a reading that do not come from an accelerometer."""
    missing: dict[str, Any] = dict.fromkeys(FELT)
    return (replace(one, **missing) for one in reading.clocks)


def profile_of(reading: Reading) -> DragProfile | None:
    """The drag profile of a reading."""
    return drag_profile(reading.clocks, measure(reading.clocks, reading.events))


def brakes(folder: Path) -> Iterator[str]:
    """The contest rocket's flights: the drag that the logs show, and the errors of the apogee."""
    flights, logs = [], {}
    for number, path in enumerate(sorted(folder.glob("contest_*.csv"))):
        reading = recorded(path, (VERTICAL,))
        found = re.search(r"contest_(\d+)_(\d+)_(\d+)", path.name)
        if reading is None or found is None:
            continue
        month, day, year = map(int, found.groups())
        when = datetime(2000 + year, month, day, 9 + number)
        measured = measure(reading.clocks, reading.events)
        fields, _ = columns(measured, {})
        mass = MASSES[f"{month}_{day}"]
        flight = Flight(path.stem, "contest", "A", "AeroTech F42T-8", dry_mass=mass, diameter=0.0556, date_time=when)
        flights.append(flight.with_changes(**fields))
        logs[path.stem] = flight_log(reading.clocks, measured)
    yield from ("", "## Flights with air brakes", "")
    yield from section(flights, logs)


def section(flights: Sequence[Flight], logs: dict[str, FlightLog]) -> Iterator[str]:
    """The drag of each flight relative to the rocket's own, and the errors of forecasts."""
    from fieldkit.flight.typed_columns import STATE_COLUMN
    from fieldkit.model.readout_data import observe
    from fieldkit.motors import catalogue
    from fieldkit.selection.diagnose import Diagnosis, diagnose
    from fieldkit.selection.extended_model import rocket_model
    from fieldkit.selection.logged_forces import LoggedForces, logged_forces

    def diagnosed(some: Sequence[Flight]) -> tuple[LoggedForces, Diagnosis]:
        motors = [catalogue().resolve(flight.motor) for flight in some]
        history = history_of(some, motors, used_in_fit=[True] * len(some))
        model = rocket_model(history)
        forces = logged_forces(model, logs)
        return forces, diagnose(model, observe(history), forces=forces)

    forces, found = diagnosed(flights)
    steps = forces.steps
    assert steps is not None
    yield from prose(
        f"One rocket with undeclared brakes. Verdict: `{found.effect}`, probability",
        f"{found.confidence:.0%}. A step multiplies drag by {1 + steps.size:.2f} ± {steps.size_sd:.2f}; the log",
        f"evidence of the coasts alone is {steps.log_bayes:+.1f}. Drag relative to the rocket's own, averaged over",
        "sixths of each coast:",
    )
    rows = []
    for one in steps.flights:
        parts = np.array_split(np.arange(one.ratio.size), PARTS)
        likely = [step for step in one.steps if step.probability > 0.5]
        listed = "; ".join(f"{s.begin:.1f} to {'the end' if s.end is None else f'{s.end:.1f}'} s" for s in likely)
        rows.append([one.flight_id, *(f"{one.ratio[part].mean():.2f}" for part in parts), listed or "none"])
    yield from table(("flight", *map(str, range(1, PARTS + 1)), "steps"), rows)
    switched = {one.flight_id: one.member > 0.5 for one in steps.flights}
    states = {name: {STATE_COLUMN: "yes" if own else "no"} for name, own in switched.items()}
    _, stated = diagnosed([flight.with_changes(extra=states.get(flight.flight_id, {})) for flight in flights])
    yield from prose(
        f"Every flight forecast from the others: mean error {found.before.mae:.1f} m without a correction; with the",
        f"verdict {found.after.mae:.1f} m if the state of the brakes on that flight is unknown, and",
        f"{stated.after.mae:.1f} m if the column `{STATE_COLUMN}` has it. The priors of the analysis were set with",
        "these flights and recordings at hand.",
    )


if __name__ == "__main__":
    main()
