"""The original bytes of logs, each stored once under its digest."""

import zlib
from collections.abc import Iterable

from sqlalchemy import Connection, insert, select

from fieldkit.files import MAX_FILE_SIZE
from fieldkit.importing.incoming import Original, digest_of
from fieldkit.ledger.finding import StoredFlight
from fieldkit.ledger.rows import DamagedRow
from fieldkit.ledger.tables import logs
from fieldkit.quantities import counted


def keep_log(connection: Connection, original: Original) -> None:
    """Store a log's bytes under their digest, once."""
    if connection.scalar(select(logs.c.digest).where(logs.c.digest == original.digest)) is None:
        row = {"digest": original.digest, "size": original.size, "content": original.compressed}
        connection.execute(insert(logs).values(**row))


def log_of(connection: Connection, stored: StoredFlight) -> bytes | None:
    """The original bytes of a stored flight's log, None if it has none. Raises DamagedRow if they are missing."""
    content = _content(connection, stored.log_digest)
    if stored.log_digest and content is None:
        raise DamagedRow(f"the log {stored.log_digest} of flight {stored.flight.flight_id} is missing")
    return content


def other_logs_of(connection: Connection, stored: StoredFlight) -> list[bytes]:
    """The original bytes of a stored flight's additional files."""
    contents = [_content(connection, digest) for digest in stored.flight.origin.others]
    return [content for content in contents if content is not None]


def check_logs(connection: Connection, digests: Iterable[str]) -> None:
    """Check stored bytes against their digests. Raises DamagedRow on a mismatch; zlib.error."""
    for digest in digests:
        _content(connection, digest)


def _content(connection: Connection, digest: str | None) -> bytes | None:
    row = connection.execute(select(logs).where(logs.c.digest == digest)).first()
    return None if row is None else _unpacked(row.content, row.size, row.digest)


def _unpacked(packed: bytes, size: int, digest: str) -> bytes:
    """Decompress the bytes of a log, at most as many as its row states. Raises DamagedRow on a mismatch; zlib.error."""
    if not 0 <= size <= MAX_FILE_SIZE:
        raise DamagedRow(f"found a log of {counted(size, 'byte')}, expected at most {MAX_FILE_SIZE}")
    content = zlib.decompressobj().decompress(packed, size + 1)
    if len(content) != size:
        raise DamagedRow(f"found a log whose size differs from the {counted(size, 'byte')} recorded for it")
    if digest_of(content) != digest:
        raise DamagedRow(f"the bytes of the log {digest} do not match their checksum")
    return content
