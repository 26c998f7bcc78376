"""Words of the loop's report: names in full, groups of flights, and the next forecast before its change."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fieldkit.presentation.loop_text import candidate_row, in_next_flight, mean_misses
from fieldkit.quantities import ShownUnits
from fieldkit.selection.candidates import EACH_GROUP, Pattern, Place

pytestmark = pytest.mark.fast
CHECK_SHAPES = False


@pytest.mark.parametrize("name", ["wear", "early_ejection_seconds of Quest E35W from flight 12 on"])
def test_a_name_is_never_cut_and_its_figures_stay_in_their_columns(name: str) -> None:
    lines = list(candidate_row(name, "+2.2"))
    assert lines[0].split("+2.2")[0].strip() == name
    assert lines[-1].index("+2.2") == 36


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (Place("motor_thrust", "AeroTech F39T"), "a weak or strong motor (AeroTech F39T)"),
        (Place("motor_thrust", EACH_GROUP), "a weak or strong motor (each motor)"),
        (Place("heavier_recovery", "", "9"), "heavier recovery gear from flight 9 on"),
        (Place(pattern=Pattern("lasting", "4")), "a change from flight 4 on"),
    ],
)
def test_the_group_of_an_effect_is_in_parentheses(place: Place, words: str) -> None:
    assert place.in_words == words


@pytest.mark.parametrize(
    ("before", "after", "change"),
    [
        (200.0, 190.0, "10 m (5.0%) lower than without a correction"),
        (190.0, 190.2, "the same as without a correction"),
    ],
)
def test_the_next_forecast_is_shown_before_its_change(before: float, after: float, change: str) -> None:
    flight: Any = SimpleNamespace(
        flight=SimpleNamespace(motor="F39"), before=before, after=after, interval=(170.0, 230.0)
    )
    assert in_next_flight(flight) == f"next F39 in the same conditions: 190 m, 90% interval 170 to 230 m; {change}"


def test_without_a_verdict_the_report_names_what_was_looked_for_and_how_good_the_plain_model_is() -> None:
    score = SimpleNamespace(mae=10.0, coverage90=0.75)
    before = SimpleNamespace(flights=4, score=score)
    data = SimpleNamespace(values=np.log([[100.0], [300.0], [999.0]]), seen=np.array([[True], [True], [False]]))
    ranking = [SimpleNamespace(effect=name) for name in ("wear", "", "wind")]
    nothing = SimpleNamespace(before=SimpleNamespace(flights=0))
    found: Any = SimpleNamespace(
        diagnosis=SimpleNamespace(effect="none", ranking=ranking, data=data),
        left_out=SimpleNamespace(before=before),
        forward=nothing,
    )
    assert list(mean_misses(found, ShownUnits("US"))) == [
        "  looked for: wear, weathercocking in the wind",
        "  without a correction: 33 ft off on average (5%), 3 of 4 inside the 90% interval; "
        "each flight forecast from the others",
    ]
