"""The correction of the loop goes with the flights of a rocket that is renamed or merged, and comes back with undo."""

from pathlib import Path
from typing import Any

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.services.model_versions import version_average
from tests.commands import Run

CORRECTION: dict[str, Any] = {
    "effects": [],
    "averaged": [
        {"probability": 0.6, "places": [{"effect": "wind", "since": "2"}]},
        {
            "probability": 0.4,
            "places": [
                {"effect": "", "pattern": {"kind": "lasting", "of": "1", "smooth": False}},
                {
                    "effect": "drag_step",
                    "switched": {"amounts": [["2", 0.3]], "usual": 0.3, "chance": 0.5, "ahead": True},
                },
            ],
        },
    ],
}


@pytest.fixture
def corrected(tmp_path: Path) -> Path:
    """A ledger with two flights each of Lark, which has a correction, and Comet."""
    with Ledger.open(path := tmp_path / "ledger.db") as ledger:
        ledger.add(
            Flight(flight_id=str(number), rocket=rocket, motor="C6-5", apogee=100.0 + number)
            for rocket in ("Lark", "Comet")
            for number in (1, 2)
        )
        ledger.keep_version("Lark", CORRECTION)
    return path


def in_use(path: Path) -> dict[str, Any]:
    """The payload of the correction in use, by rocket."""
    with Ledger.open(path) as ledger:
        found = {rocket: ledger.active_version(rocket) for rocket in ("Lark", "Swift", "Comet")}
        return {rocket: version.payload for rocket, version in found.items() if version}


def test_a_correction_goes_with_a_renamed_rocket_and_undo_takes_both_back(run: Run, corrected: Path) -> None:
    run("edit", "Lark", "rocket=Swift")
    assert in_use(corrected) == {"Swift": CORRECTION}
    run("undo")
    assert in_use(corrected) == {"Lark": CORRECTION}
    with Ledger.open(corrected) as ledger:
        assert len(ledger.flights("Lark")) == 2
    run("redo")
    assert in_use(corrected) == {"Swift": CORRECTION}


def test_in_a_merged_rocket_a_correction_starts_at_the_same_flights_by_their_new_ids(run: Run, corrected: Path) -> None:
    assert "the correction of Lark is now used for every flight of Comet" in run("edit", "Lark", "rocket=Comet").err
    moved = in_use(corrected)
    assert moved.keys() == {"Comet"}
    (_, (wind,)), (_, (lasting, step)) = version_average(moved["Comet"])
    assert (wind.since, lasting.pattern and lasting.pattern.of) == ("4", "3")
    assert step.switched is not None
    assert step.switched.amounts == (("4", 0.3),)


def test_a_correction_stays_where_flights_stay_and_yields_to_one_of_the_other_rocket(run: Run, corrected: Path) -> None:
    run("edit", "Lark/1", "rocket=Swift")
    assert in_use(corrected) == {"Lark": CORRECTION}
    own = {"effects": [], "averaged": [{"probability": 1.0, "places": []}]}
    with Ledger.open(corrected) as ledger:
        ledger.keep_version("Comet", own)
    assert "the correction of Lark is not used: Comet has its own" in run("edit", "Lark", "rocket=Comet").err
    assert in_use(corrected)["Comet"] == own
