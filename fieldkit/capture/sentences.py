"""The sentences of bdureau's altimeters: `$name,field,...,checksum;`.

The checksum is the sum of the characters from the name up to and including the comma before the checksum, modulo 256.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from fieldkit.importing.tables.checksums import sum_256


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence; `sound` if its checksum is valid, or if its kind has none."""

    name: str
    fields: tuple[str, ...]
    sound: bool


def sentence(piece: bytes) -> Sentence | None:
    """The sentence at the end of the text before a semicolon, None if there is none."""
    start = piece.rfind(b"$")
    if start < 0:
        return None
    body = piece[start + 1 :]
    name, *fields = body.decode("latin-1").split(",")
    if not fields:
        return Sentence(name.strip(), (), name.strip().isalnum())
    right = str(sum_256(body[: body.rfind(b",") + 1])) == fields[-1].strip()
    return Sentence(name, tuple(fields[:-1]), right)


def sentences(content: bytes) -> Iterable[Sentence]:
    """All sentences in a sequence of bytes."""
    for piece in content.split(b";")[:-1]:
        if (one := sentence(piece)) is not None:
            yield one
