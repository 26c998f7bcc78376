"""Output of devices: their noise, units and bytes."""

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from fieldkit.units import FOOT


def noise(seed: int, size: int, scale: float) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, scale, size)


def feet(height: np.ndarray, seed: int) -> np.ndarray:
    return np.round((height + noise(seed, len(height), 0.25)) / FOOT).astype(int)


def text(lines: list[str], end: str = "\n") -> bytes:
    return "".join(line + end for line in lines).encode()


def little(value: float, size: int) -> bytes:
    return round(value).to_bytes(size, "little", signed=value < 0)


def table(header: str, columns: Sequence[Sequence[str]], separator: str = ",", end: str = "\n") -> bytes:
    """A text table of columns of cells."""
    rows = [separator.join(cells) for cells in zip(*columns, strict=True)]
    return (header + end + "".join(row + end for row in rows)).encode()


def cells(values: np.ndarray, form: str) -> list[str]:
    return [format(value, form) for value in values]


def clock(now: datetime) -> str:
    return f"{now:%H:%M:%S}.{now.microsecond // 1000:03d}"
