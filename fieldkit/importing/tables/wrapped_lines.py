"""Lines that a mail program or a spreadsheet wrapped: `> ` before each line, or each whole line in quotation marks."""

import re

from fieldkit.importing.tables.text import first_lines, narrow

_LOOKED_AT, _MAX_LINE, _MAX_SIZE = 60, 4096, 32 << 20
"""Number of first lines that show a wrapping [1], what is looked at of each [character], and the largest size of a text
that is unwrapped [byte]."""
_CITED, _QUOTED = re.compile(r"[ \t]{0,8}>"), re.compile(r'"(?:[^"]|"")*"[,; \t\r]*')
_CITATION = re.compile(rb"^[ \t]{0,8}>[ \t]?", re.MULTILINE)
_QUOTATION = re.compile(rb'^"((?:[^"\r\n]|"")*)"[,; \t]*(?=\r?$)', re.MULTILINE)


def unwrapped(log: bytes) -> bytes:
    """A log without what wraps each of its lines; unchanged if one of its first lines is not wrapped, or it is too
    large. Raises DamagedLog."""
    start = [line[:_MAX_LINE] for line in first_lines(log, most=_LOOKED_AT) if line.strip()]
    if len(log) > _MAX_SIZE or len(start) < 2:
        return log
    if all(map(_CITED.match, start)):
        return _CITATION.sub(b"", narrow(log))
    if all(map(_QUOTED.fullmatch, start)):
        return _QUOTATION.sub(lambda line: line[1].replace(b'""', b'"'), narrow(log))
    return log
