"""The hyperprior: its card round-trips, errors in a card are named, and learned figures match the card."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedModel
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import READOUTS, START, learned, read_card
from fieldkit.model.scale import Scale

pytestmark = pytest.mark.fast


def test_a_card_round_trips() -> None:
    again = read_card(json.dumps(learned().json()), "card")
    assert again.json() == learned().json()
    assert again.sds == learned().sds


def test_learned_and_starting_hyperprior_have_the_same_effects() -> None:
    assert set(learned().sds) == set(START.sds)
    assert all(sd > 0 for sd in learned().sds.values())


def test_an_older_card_lacks_means_and_readouts_from_samples() -> None:
    card = learned().json()
    del card["mean_sds"]
    card["sds"] = {name: sd for name, sd in card["sds"].items() if not name.endswith(".logged")}
    card.pop("motors", None)
    card["scatter"].pop("of", None)
    found = read_card(json.dumps(card), "old.json")
    assert found.fleet_sd("drag") == found.sd("drag", "fleet")
    assert found.sd("top_speed", "logged") == START.sd("top_speed", "logged")
    assert found.motor_scales().tolist() == found.scales()[0].tolist(), "one scale for motors and apogees"
    card["scatter"]["of"] = "apogee"
    assert read_card(json.dumps(card), "older.json").motors == START.motors


def test_a_readout_that_the_card_does_not_know_has_the_error_of_the_start() -> None:
    """Adding a readout to the fit does not make the shipped card, or a flyer's own, unreadable."""
    card = learned().json()
    card["noise"] = {name: noise for name, noise in card["noise"].items() if name != "peak_accel"}
    found, place = read_card(json.dumps(card), "older.json"), READOUTS.index("peak_accel")
    assert (found.fixed[place], found.ratio[place]) == (START.fixed[place], START.ratio[place])
    assert found.fixed[:place] == learned().fixed[:place]


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ({"sds": {"drag.rocket": -0.1}}, "negative"),
        ({"sds": {"drag.rocket": float("nan")}}, "negative or not finite"),
        ({"sds": {"drag.moon": 0.1}}, "unknown effect 'drag.moon'"),
        ({"mean_sds": {"drag": -0.1}}, "negative"),
        ({"noise": {}}, "expected a hyperprior"),
        ({"tail": "many"}, "expected a hyperprior"),
        ({"tail": 0.0}, "zero"),
        ({"scatter": {"median": 1.0, "log_sd": 0.0}}, "zero"),
        ({"motors": {"median": 1.0, "log_sd": 0.0}}, "zero"),
        ({"motors": {"median": 1.0}}, "expected a hyperprior"),
        ({"reading": {"median": -1.0, "log_sd": 0.5}}, "negative"),
        ({"opening_s": [float("nan"), 0.4]}, "not finite"),
        ({"opening_s": [0.6, 0.0]}, "zero"),
    ],
)
def test_an_invalid_card_is_refused_by_file_and_fault(change: dict[str, object], wanted: str) -> None:
    card = {**learned().json(), **change}
    with pytest.raises(DamagedModel, match=wanted) as found:
        read_card(json.dumps(card), "club.json")
    assert str(found.value).startswith("club.json")


def test_the_flyers_own_card_replaces_the_shipped_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    shipped = learned.__wrapped__()
    (tmp_path / "hyperprior.json").write_text(json.dumps(shipped.with_sds(drag__rocket=0.5).json()))
    assert learned.__wrapped__().sd("drag", "rocket") == 0.5
    assert shipped.sd("drag", "rocket") != 0.5


def test_scales_are_weighted_by_a_log_normal() -> None:
    scale = Scale((0.5, 1.0, 2.0), 1.0, 0.7)
    assert scale.log_prior[0] == pytest.approx(scale.log_prior[2])
    assert scale.log_prior[1] == 0.0
    scatter, reading, log_prior = replace(CERTIFIED_PRIOR, scatter=scale).scales()
    assert len(scatter) == len(reading) == len(log_prior) == 3 * len(CERTIFIED_PRIOR.reading.grid)
    assert np.exp(log_prior).sum() == pytest.approx(1.0)
