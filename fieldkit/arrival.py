"""A flight on its way into the ledger, with the bytes it was read from."""

import hashlib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

from fieldkit.flight import Flight


@dataclass(frozen=True, slots=True, eq=False)
class Original:
    """The bytes of a log as they are kept: `digest` is their SHA-256 in hex, `size` theirs before zlib packed them."""

    digest: str
    size: int
    packed: bytes

    @classmethod
    def of(cls, content: bytes) -> "Original":
        """A log's bytes, packed."""
        return cls(digest_of(content), len(content), zlib.compress(content))


def digest_of(content: bytes) -> str:
    """The name of a log's bytes."""
    return hashlib.sha256(content).hexdigest()


@dataclass(frozen=True, slots=True)
class Arrival:
    """A flight on its way in, with the original bytes it was read from, and their file and row.

    `given` is what the flyer says of it beside these bytes, by field, or None where that is not known: the rest may
    be read or measured otherwise on another day and does not make it another flight. `others` are further files that
    its logger wrote of it.
    """

    flight: Flight
    log: Original | None = None
    source: str = ""
    row: int | None = None
    given: Mapping[str, object] | None = None
    others: tuple[Original, ...] = ()


OTHER_LOGS = "other_logs"
"""The extra column of a flight that names the digests of `Arrival.others`, apart by blanks."""
