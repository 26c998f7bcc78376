"""Units of the values in rules, as factors to SI."""

from collections.abc import Mapping

from fieldkit.units import DEGREE, FOOT, MILE, POUND

RULE_UNITS: Mapping[str, float] = {
    "1": 1.0,
    "level": 1.0,
    "m": 1.0,
    "ft": FOOT,
    "g": 1e-3,
    "lb": POUND,
    "deg": DEGREE,
    "m/s": 1.0,
    "mph": MILE / 3600,
    "N": 1.0,
    "N s": 1.0,
}
"""SI value of one of each unit."""
