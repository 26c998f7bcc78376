"""Checksums that loggers send with their data."""

import binascii

_REVERSED_BYTES = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def _buypass(byte: int) -> int:
    value = byte << 8
    for _ in range(8):
        value = (value << 1 ^ (0x8005 if value & 0x8000 else 0)) & 0xFFFF
    return value


BUYPASS = tuple(map(_buypass, range(256)))
"""CRC-16/BUYPASS of each byte."""


def crc_x25(data: bytes) -> int:
    """CRC-16/X-25, used by MicroPeak: "123456789" gives 0x906e. It is Python's CRC with the bits reversed."""
    straight = binascii.crc_hqx(data.translate(_REVERSED_BYTES), 0xFFFF)
    return int(f"{straight:016b}"[::-1], 2) ^ 0xFFFF


def crc_buypass(data: bytes) -> int:
    """CRC-16/BUYPASS, used by Blue Raven: "123456789" gives 0xfee8."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFFFF) ^ BUYPASS[crc >> 8 ^ byte]
    return crc


def sum_256(data: bytes, start: int = 0) -> int:
    """Sum of all bytes modulo 256, used by AltiMulti and, starting from 0x5a, by AltOS."""
    return (start + sum(data)) % 256
