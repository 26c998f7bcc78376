"""Features do not change with the code that computes them: networks were trained on them."""

import json

import pytest

from tests.inference.history.stored_features import CASES, FILE, features

CHECK_SHAPES = False


@pytest.mark.parametrize("case", CASES)
def test_features_are_those_that_networks_are_trained_on(case: str) -> None:
    """An effect added since is not a candidate here."""
    kept = json.loads(FILE.read_text(encoding="utf-8"))
    assert features(case, kept["effects"]) == pytest.approx(kept["features"][case], rel=1e-6, abs=1e-6)
