"""JSON that holds the columns of a table rather than its rows, as programs in Python save them, as CSV.

`{"time_s": [0, 0.04], "altitude_m": [0.1, 0.3]}`, the same with `{"0": 0, "1": 0.04}` for each list, or
`{"columns": ["time_s", "altitude_m"], "data": [[0, 0.1], [0.04, 0.3]]}`, also inside another object.

Source: `DataFrame.to_json` in the documentation of pandas, orients `columns` and `split`.
"""

import csv
import io
import json
from collections.abc import Iterator, Sequence
from typing import Any

_MAX_SIZE, _MIN_ROWS, _DEPTH = 32 << 20, 10, 3
"""Largest size of such a text [bytes], fewest rows that form a table, and how deep it is looked for. [1]"""


def columns_table(log: bytes) -> bytes | None:
    """The table in a JSON text as CSV; None if it is none, has too few rows, or is too large."""
    if len(log) > _MAX_SIZE or not log.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        return None
    try:
        document = json.loads(log.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return None
    names, rows = next(_tables(document, _DEPTH), ((), ()))
    if len(rows) < _MIN_ROWS:
        return None
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([names, *rows])
    return text.getvalue().encode()


def _tables(document: Any, depth: int) -> Iterator[tuple[Sequence[str], Sequence[Sequence[Any]]]]:
    """The names and rows of each table in an object."""
    if not isinstance(document, dict) or not depth:
        return
    names, rows = (document.get(one) for one in ("columns", "data"))
    if isinstance(names, list) and isinstance(rows, list) and all(_is_flat(r) and len(r) == len(names) for r in rows):
        yield [str(name) for name in names], rows
        return
    columns = {str(name): list(one.values()) if isinstance(one, dict) else one for name, one in document.items() if one}
    columns = {name: one for name, one in columns.items() if _is_flat(one)}
    longest = max(map(len, columns.values()), default=0)
    whole = {name: one for name, one in columns.items() if len(one) == longest}
    if len(whole) > 1 and longest >= _MIN_ROWS:
        yield list(whole), list(zip(*whole.values(), strict=True))
    for one in document.values():
        yield from _tables(one, depth - 1)


def _is_flat(values: Any) -> bool:
    return isinstance(values, list) and not any(isinstance(one, list | dict) for one in values)
