"""The checksums that loggers send along with their data."""

from functools import cache


@cache
def _reflected(polynomial: int) -> tuple[int, ...]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (polynomial if byte & 1 else 0)
        table.append(byte)
    return tuple(table)


@cache
def _straight(polynomial: int) -> tuple[int, ...]:
    table = []
    for byte in range(256):
        value = byte << 8
        for _ in range(8):
            value = (value << 1 ^ (polynomial if value & 0x8000 else 0)) & 0xFFFF
        table.append(value)
    return tuple(table)


def crc_x25(data: bytes) -> int:
    """CRC-16/X-25, of MicroPeak: "123456789" gives 0x906e."""
    table = _reflected(0x8408)
    crc = 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFF


def crc_buypass(data: bytes) -> int:
    """CRC-16/BUYPASS, of Blue Raven: "123456789" gives 0xfee8."""
    table = _straight(0x8005)
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFFFF) ^ table[crc >> 8 ^ byte]
    return crc


def sum_256(data: bytes, start: int = 0) -> int:
    """The sum of all bytes, modulo 256, of AltiMulti and, from 0x5a, of AltOS."""
    return (start + sum(data)) % 256
