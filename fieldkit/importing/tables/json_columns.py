"""JSON that holds the columns of a table rather than its rows, as programs in Python save them, as CSV.

`{"time_s": [0, 0.04], "altitude_m": [0.1, 0.3]}`, the same with `{"0": 0, "1": 0.04}` for each list, or
`{"columns": ["time_s", "altitude_m"], "data": [[0, 0.1], [0.04, 0.3]]}`, also inside another object.

Source: `DataFrame.to_json` in the documentation of pandas, orients `columns` and `split`.
"""

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import Any

from fieldkit.importing.tables.text import MAX_TABLE_LINES, MAX_TABLE_SIZE

_MIN_ROWS, _DEPTH = 10, 3
"""Fewest rows that form a table, and how deep it is looked for. [1]"""


def columns_table(log: bytes) -> bytes | None:
    """The table in a JSON text as CSV; None if it is none, has too few rows, or is too large."""
    if len(log) > MAX_TABLE_SIZE or not log.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        return None
    if sum(map(log.count, (b"{", b"["))) > MAX_TABLE_LINES:  # each takes more memory than the file
        return None
    try:
        document = json.loads(log.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return None
    for names, rows in _tables(document, _DEPTH):
        table = io.BytesIO()
        text = io.TextIOWrapper(table, "utf-8", errors="replace", newline="")  # half a pair of surrogates is no text
        csv.writer(text, lineterminator="\n").writerows(chain([names], rows))
        text.flush()
        return table.getvalue()
    return None


def _tables(document: Any, depth: int) -> Iterator[tuple[Sequence[str], Iterable[Sequence[Any]]]]:
    """The names and rows of each table in an object that has enough of them."""
    if not isinstance(document, dict) or not depth:
        return
    names, rows = (document.get(one) for one in ("columns", "data"))
    if isinstance(names, list) and isinstance(rows, list) and all(_is_flat(r) and len(r) == len(names) for r in rows):
        if len(rows) >= _MIN_ROWS:
            yield [str(name) for name in names], rows
        return
    columns = {str(name): list(one.values()) if isinstance(one, dict) else one for name, one in document.items() if one}
    columns = {name: one for name, one in columns.items() if _is_flat(one)}
    longest = max(map(len, columns.values()), default=0)
    whole = {name: one for name, one in columns.items() if len(one) == longest}
    if len(whole) > 1 and longest >= _MIN_ROWS:
        yield list(whole), zip(*whole.values(), strict=True)
    for one in document.values():
        yield from _tables(one, depth - 1)


def _is_flat(values: Any) -> bool:
    return isinstance(values, list) and not any(isinstance(one, list | dict) for one in values)
