"""A closed loop in one sentence that a flyer can act on."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.physics.effect import effects
from fieldkit.presentation.loop_headline import compared_bars, headline, sentence_of
from fieldkit.selection.candidates import EACH_GROUP, Place
from fieldkit.selection.unexplained import Leftover

CHECK_SHAPES = False


def trial(place: Place, strength: float) -> Any:
    unit = effects()[place.effect].unit
    return SimpleNamespace(candidate=SimpleNamespace(place=place), strength=lambda: (strength, 0.01), unit=unit)


def found(*accepted: Any, confidence: float = 0.9, after: float = 10.0) -> Any:
    flights = [Flight("1", "Astra", "C", dry_mass=0.44), Flight("2", "Astra", "A", dry_mass=0.32)]
    judged = [SimpleNamespace(score=SimpleNamespace(mae=mae)) for mae in (23.0, after)]
    places = tuple(one.candidate.place for one in accepted)
    return SimpleNamespace(
        rocket="Astra",
        diagnosis=SimpleNamespace(
            accepted=accepted,
            effect="+".join(place.effect for place in places) or "none",
            averaged=((1.0, places),),
            confidence=confidence,
            ranking=(),
            model=SimpleNamespace(flights=flights),
        ),
        left_out=SimpleNamespace(before=judged[0], after=judged[1]),
        unexplained=None,
        tests=(),
    )


def test_a_wrong_mass_is_in_grams_or_ounces_with_what_to_do() -> None:
    lighter = trial(Place("mass_offset", "C"), -0.15)
    one = headline(found(lighter))
    assert one.sentence == "Astra C is about 66 g lighter than entered."
    assert one.step == "Weigh the rocket again, ready to fly but without the motor."
    assert (one.before, one.after) == (23.0, 10.0)
    assert "2.33 oz lighter" in headline(found(lighter), "US").sentence
    assert headline(found(lighter, confidence=0.63)).sentence.startswith("Probably (63%): Astra C is about")


def test_a_weak_motor_is_named_in_percent_and_from_which_flight_on() -> None:
    weak = trial(Place("motor_thrust", "AeroTech F24W", "7"), -0.12)
    sentence = headline(found(weak)).sentence
    assert sentence == "AeroTech F24W delivers about 12% less thrust than certified from flight 7 on."


def test_a_second_effect_follows_the_first() -> None:
    both = found(trial(Place("mass_offset", "C"), 0.1), trial(Place("wear"), 0.03))
    assert headline(both).also == ("Astra gains about 3% of drag with every flight.",)


@pytest.mark.parametrize("name", list(effects()))
@pytest.mark.parametrize("strength", [-0.3, 0.3])
@pytest.mark.parametrize("where", ["", "B", EACH_GROUP])
def test_every_effect_has_a_sentence_without_a_placeholder(name: str, strength: float, where: str) -> None:
    for system in ("SI", "US"):
        sentence = sentence_of(found(), trial(Place(name, where), strength), system)
        assert sentence.endswith(".")
        assert sentence[0].isupper()
        assert not {"{", "}", "\x1f"} & set(sentence)


def test_without_a_name_the_sentence_says_whether_something_is_missing() -> None:
    assert headline(found()).sentence == "Astra flies as its model says: nothing is missing."
    assert headline(found()).after is None
    assert headline(found(confidence=0.35)).sentence.startswith("Something may be missing (65%)")


def test_a_contradiction_that_follows_nothing_is_named_itself() -> None:
    one = found()
    one.unexplained = Leftover("", np.zeros(2, bool), 0.0, 0.0)
    one.diagnosis.why = "no known effect explains an unusual drag; a pattern as clear arises in < 1% of such histories"
    assert headline(one).sentence == f"N{one.diagnosis.why[1:]}."
    one.unexplained = Leftover("on 2020-05-01", np.array([True, False]), -0.2, 0.05)
    assert headline(one).sentence.startswith(
        "No known effect explains that the one flight on 2020-05-01 flies 20% lower"
    )


def test_bars_have_the_ratio_of_the_misses() -> None:
    (_, before, _), (_, after, _) = compared_bars(headline(found(trial(Place("wear"), 0.03), after=11.5)), 20, "SI")
    assert (len(before), len(after)) == (20, 10)
