"""A flight to be imported, together with the bytes it was read from."""

import hashlib
import io
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

from fieldkit.flight import Flight

_PIECE = 1 << 20
"""Size of the pieces in which a log is compressed. [bytes]"""


@dataclass(frozen=True, slots=True, eq=False)
class Original:
    """The stored bytes of a log: `digest` is their SHA-256 in hex, `size` their size before compression by zlib."""

    digest: str
    size: int
    compressed: bytes

    @classmethod
    def of(cls, content: bytes) -> "Original":
        """A log's bytes, compressed."""
        return cls(digest_of(content), len(content), _packed(content))


def _packed(content: bytes) -> bytes:
    """Compress the bytes in pieces, because a single call would hold the output of a long log twice."""
    packer, compressed, view = zlib.compressobj(), io.BytesIO(), memoryview(content)
    for start in range(0, len(content), _PIECE):
        compressed.write(packer.compress(view[start : start + _PIECE]))
    compressed.write(packer.flush())
    return compressed.getvalue()


def digest_of(content: bytes) -> str:
    """The digest of a log's bytes."""
    return hashlib.sha256(content).hexdigest()


@dataclass(frozen=True, slots=True)
class IncomingFlight:
    """A flight being imported, with the original bytes it was read from, and their file and row.

    `given` contains the fields that the flyer entered in addition to these bytes, or None if unknown. The remaining
    fields may be read or measured differently later without making it another flight. `others` are further files that
    its logger wrote for the flight.
    """

    flight: Flight
    log: Original | None = None
    source: str = ""
    row: int | None = None
    given: Mapping[str, object] | None = None
    others: tuple[Original, ...] = ()
