"""Variants of the sample log of every parser: what editors, spreadsheets and downloads do to a file."""

from collections.abc import Callable, Mapping


def _rows(log: bytes) -> list[bytes]:
    return log.split(b"\n")


def _doubled(log: bytes) -> bytes:
    """A row in the middle twice."""
    lines = _rows(log)
    middle = len(lines) // 2
    return b"\n".join([*lines[:middle], lines[middle], *lines[middle:]])


def _damaged(log: bytes) -> bytes:
    """A row in the middle cut short."""
    lines = _rows(log)
    middle = len(lines) // 2
    return b"\n".join([*lines[:middle], lines[middle][: len(lines[middle]) // 3], *lines[middle + 1 :]])


FILES: Mapping[str, Callable[[bytes], bytes]] = {
    "line ends of Windows": lambda log: log.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"),
    "line ends of an old Mac": lambda log: log.replace(b"\r\n", b"\n").replace(b"\n", b"\r"),
    "a byte order mark": lambda log: b"\xef\xbb\xbf" + log.removeprefix(b"\xef\xbb\xbf"),
    "saved as UTF-16": lambda log: log.decode("latin-1").removeprefix("\xef\xbb\xbf").encode("utf-16"),
    "blank lines below": lambda log: log + b"\n\n\n",
    "NULs below": lambda log: log + bytes(512),
    "no last line end": lambda log: log.rstrip(b"\r\n\0"),
    "the last row cut short": lambda log: log.rstrip(b"\r\n\0")[:-7],
    "a row twice": _doubled,
    "a row damaged": _damaged,
    "the last tenth lost": lambda log: b"\n".join(_rows(log)[: len(_rows(log)) * 9 // 10]) + b"\n",
}
"""Kinds of variants by what was done."""
