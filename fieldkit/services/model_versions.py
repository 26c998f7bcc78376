"""Reading the model versions saved in a ledger, which any program may have written."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, get_args, get_type_hints

from fieldkit.errors import BadValue
from fieldkit.forecast.conformal import are_numbers
from fieldkit.ledger import Version
from fieldkit.physics.effect import effect_named
from fieldkit.selection.candidates import ORDINALS, Averaged, Pattern, Place, Switched

KINDS = get_args(get_type_hints(Pattern)["kind"])
"""The kinds of patterns."""
ROUNDING = 0.01
"""Probabilities of rounded sets add up to 1 within this. [1]"""


def version_average(payload: Mapping[str, Any]) -> Averaged:
    """The sets of effects in a model version's average, the most probable first; one set for a version from before
    averaging. Raises BadValue for a version that this program did not write."""
    try:
        if "averaged" not in payload:
            return ((1.0, version_places(payload)),)
        found = tuple((float(one["probability"]), _places(one["places"])) for one in payload["averaged"])
        if not all(0 <= chance <= 1 for chance, _ in found) or abs(sum(chance for chance, _ in found) - 1) > ROUNDING:
            raise ValueError("found no probabilities")
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise BadValue(
            "found a saved model that this program cannot read, expected one of `fieldkit loop`; run it again"
        ) from error
    return found


def version_summary(version: Version) -> tuple[str, float | None, float | None]:
    """The effects that a model version adds, in words, each set with its probability, `wear 80%, nothing 20%`, and its
    mean absolute errors before and after [m]; for what this program cannot read, a phrase and None."""
    errors = [version.payload.get(when) for when in ("before", "after")]
    found: list[Any] = [one.get("mae_m") if isinstance(one, Mapping) else None for one in errors]
    before, after = (float(one) if are_numbers([one], 1) else None for one in found)
    try:
        return _adds(version_average(version.payload)), before, after
    except BadValue:
        return "cannot be read by this program", before, after


def _adds(sets: Averaged) -> str:
    named = [" and ".join(place.in_words for place in places) or "nothing" for _, places in sets]
    added = ", ".join(f"{name} {chance:.0%}" for name, (chance, _) in zip(named, sets, strict=True))
    return named[0] if len(named) == 1 else added


def version_places(payload: Mapping[str, Any]) -> tuple[Place, ...]:
    """The effects of a model version and its pattern in the residuals, if any, each in its place. Raises KeyError,
    TypeError, ValueError or AttributeError for a version that this program did not write."""
    entries = [*payload["effects"], *payload.get("unexplained", {}).get("pattern", [])]
    return _places(entries)


def _places(entries: Sequence[Mapping[str, Any]]) -> tuple[Place, ...]:
    return tuple(map(_place, entries))


def _place(entry: Mapping[str, Any]) -> Place:
    """A saved place; one of an older version has its pattern as text."""
    effect, where, since = entry["effect"], entry.get("where", ""), entry.get("since", "")
    if not all(isinstance(text, str) for text in (effect, where, since)):
        raise TypeError("found no text, expected the name of an effect, a group or a flight")
    if effect:
        effect_named(effect)
        return Place(effect, where, since, switched=_switched(entry.get("switched")))
    return Place(pattern=_pattern(**entry["pattern"]) if entry.get("pattern") else _older_pattern(where))


def _pattern(kind: Any, of: str = "", value: str = "", every: int = 0, smooth: bool = False) -> Pattern:
    texts = all(isinstance(text, str) for text in (of, value)) and bool(of or kind in ("hour", "count"))
    if kind not in KINDS or not texts or (kind == "repeated" and every not in ORDINALS):
        raise ValueError("found no pattern of this program")
    return Pattern(kind, of, value, every, bool(smooth))


def _older_pattern(text: str) -> Pattern:
    if not text:
        raise ValueError("found neither an effect nor a pattern")
    what, smooth = text.removesuffix(", smoothly"), text.endswith(", smoothly")
    if what in ("the hour of the day", "the number of flights"):
        return Pattern("hour" if "hour" in what else "count", smooth=smooth)
    if found := re.fullmatch(r"the (day|site) (.+)", what):
        return Pattern("day" if found[1] == "day" else "site", found[2])
    if found := re.fullmatch(r"every flight from (.+) on", what):
        return Pattern("lasting", found[1])
    if found := re.fullmatch(r"every (\d+) flights, as (.+)", what):
        return Pattern("repeated", found[2], every=int(found[1]))
    header, _, value = what.partition(" ")
    return Pattern("text", header, value) if value else Pattern("number", header, smooth=smooth)


def _switched(entry: Mapping[str, Any] | None) -> Switched | None:
    if not entry:
        return None
    amounts = tuple((str(name), float(amount)) for name, amount in entry["amounts"])
    if not are_numbers([*(amount for _, amount in amounts), entry["usual"], entry["chance"]], len(amounts) + 2):
        raise ValueError("found no finite amounts")
    return Switched(amounts, entry["usual"], entry["chance"], bool(entry["ahead"]))
