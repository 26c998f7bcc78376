"""The flyer's card as texts: what the app's form shows reads back as the same card."""

import pytest

from fieldkit.errors import BadValue
from fieldkit.services.flyer_card import card_texts, read_card
from fieldkit.settings import BoxedMotors, FlyerCard, Settings

CARDS = [
    FlyerCard(),
    FlyerCard(0, "2009", (0.9144,), (BoxedMotors("C6-5", 3),)),
    FlyerCard(2, "2001-05-31", (1.0, 1.8), (BoxedMotors("D12-5", 2, "0412"), BoxedMotors("AeroTech F24W-4", 1))),
]


@pytest.mark.parametrize("system", ["SI", "US"])
@pytest.mark.parametrize("card", CARDS)
def test_the_texts_of_a_card_read_back_as_the_same_card(card: FlyerCard, system: str) -> None:
    texts = card_texts(Settings(flyer=card, rules="NAR,FAA"), system, card.box)
    found = {name: read_card(name, texts[name]) for name in texts}
    assert found.pop("rules") == "NAR,FAA"
    rails = found.pop("rails")
    assert rails == pytest.approx(card.rails, abs=0.002)
    assert found == {"certification": card.certification, "born": card.born, "box": card.box}


@pytest.mark.parametrize(
    ("name", "text"),
    [("certification", "4"), ("born", "yesterday"), ("rules", "Nowhere"), ("rails", "-3ft"), ("box", "0 x C6-5")],
)
def test_an_entry_that_cannot_be_read_says_what_would_be_right(name: str, text: str) -> None:
    with pytest.raises(BadValue, match=r"expected|did you mean"):
        read_card(name, text)
