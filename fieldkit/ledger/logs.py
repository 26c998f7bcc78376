"""The original bytes of logs, kept once each under their digest."""

import zlib

from sqlalchemy import Connection, insert, select

from fieldkit.arrival import OTHER_LOGS, Original
from fieldkit.errors import LedgerError
from fieldkit.files import LARGEST
from fieldkit.ledger.finding import Held
from fieldkit.ledger.rows import DamagedRow
from fieldkit.ledger.tables import logs


def keep_log(connection: Connection, original: Original) -> None:
    """Keep a log's bytes under their digest, once."""
    if connection.scalar(select(logs.c.digest).where(logs.c.digest == original.digest)) is None:
        row = {"digest": original.digest, "size": original.size, "content": original.packed}
        connection.execute(insert(logs).values(**row))


def log_of(connection: Connection, held: Held) -> bytes | None:
    """The original bytes of a held flight's log, None where it came without. Raises DamagedRow where they are gone."""
    content = _content(connection, held.log_digest)
    if held.log_digest and content is None:
        raise DamagedRow(f"the log {held.log_digest} of flight {held.flight.flight_id} is gone")
    return content


def other_logs_of(connection: Connection, held: Held) -> list[bytes]:
    """The original bytes of the further files of a held flight."""
    contents = [_content(connection, digest) for digest in held.flight.extra.get(OTHER_LOGS, "").split()]
    return [content for content in contents if content is not None]


def _content(connection: Connection, digest: str | None) -> bytes | None:
    row = connection.execute(select(logs.c.content, logs.c.size).where(logs.c.digest == digest)).first()
    return None if row is None else _unpacked(row.content, row.size)


def _unpacked(packed: bytes, size: int) -> bytes:
    """The bytes of a log, never more than its row says. Raises LedgerError for another size, zlib.error."""
    if not 0 <= size <= LARGEST:
        raise LedgerError(f"found a log of {size} bytes, expected at most {LARGEST}")
    unpacking = zlib.decompressobj()
    content = unpacking.decompress(packed, size + 1)
    if len(content) != size:
        raise LedgerError(f"found a log of another size than the {size} bytes of its row, which is damaged")
    return content
