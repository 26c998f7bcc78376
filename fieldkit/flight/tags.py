"""The tags of flights, and which of them exclude a flight from the fit."""

import re
from collections.abc import Mapping
from types import MappingProxyType

TAGS: Mapping[str, str] = MappingProxyType(
    {
        "weak_launch": "The motor delivered too little thrust: slow off the pad.",
        "off_axis": "The rocket flew clearly off vertical.",
        "extra_drag": "Something stuck out or came loose: more drag than usual.",
        "early_ejection": "The ejection charge fired well before apogee.",
        "altimeter_fault": "The altimeter's readings are not reliable.",
        "damaged": "The rocket broke in flight.",
        "cato": "The motor failed.",
        "staged": "A flight with more than one stage burning.",
        "cluster": "A flight on several motors at once.",
    }
)
"""Tags that mark a flight as an anomaly: it stays in the ledger and is not used in the fit."""
CHECKED_TAG = "checked"
KNOWN_TAGS: Mapping[str, str] = MappingProxyType(
    {**TAGS, CHECKED_TAG: "No anomaly: every readout was checked and is right, even if one disagrees with the others."}
)
"""Every tag that has a meaning in fieldkit."""


def read_tags(text: str) -> tuple[str, ...]:
    """Parse tags separated by `;`, `|` or `,`, each once; known ones are normalized, `Weak launch` to `weak_launch`,
    others are unchanged."""
    tags = [tag.strip() for tag in re.split(r"[;|,]", text) if tag.strip()]
    known = [re.sub(r"[\s-]+", "_", tag.lower()) for tag in tags]
    return tuple(dict.fromkeys(k if k in KNOWN_TAGS else tag for k, tag in zip(known, tags, strict=True)))
