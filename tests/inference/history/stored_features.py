"""Features of a few histories in a file: `python -m tests.inference.history.stored_features` writes it again.

A network must be trained again when they change, because it is used with the features it was trained on.
"""

import json
from collections.abc import Sequence
from pathlib import Path

from fieldkit.inference.history.features import PreparedHistory, effect_names, feature_names, modeled, summarized
from fieldkit.inference.history.response import respond
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.rocket_model import Model
from fieldkit.selection.candidates import Candidate
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import READOUTS, history

FILE = Path(__file__).with_name("features.json")
CASES = {
    "one flight": {"count": 1, "recorded": ("apogee",)},
    "six flights": {"count": 6, "seed": 1, "recorded": (*READOUTS, "burn_time", "apogee_to_eject", "duration")},
    "ten flights with wear": {"count": 10, "seed": 2, "wear": 0.06},
}


def features(case: str, names: Sequence[str]) -> dict[str, float]:
    """The features of a case, with only some effects as candidates."""

    def candidates(model: Model) -> list[Candidate]:
        return [one for one in quick_candidates(model) if not one.effect or one.effect in names]

    flown = history(**CASES[case])
    ready = PreparedHistory(modeled(flown, candidates, forecast=CERTIFIED_PRIOR), respond(flown))
    row = summarized(ready, ready.flown, names).features[0]
    return dict(zip(feature_names(names), row.tolist(), strict=True))


def write() -> None:
    """Write the features of all cases, with all effects."""
    names = effect_names()
    kept = {case: {name: round(value, 9) for name, value in features(case, names).items()} for case in CASES}
    FILE.write_text(json.dumps({"effects": names, "features": kept}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write()
