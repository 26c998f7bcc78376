"""OpenRocket designs (`.ork`): what a starting configuration needs, read as facts; never a flight."""

from fieldkit.openrocket.archive import MAX_UNPACKED_SIZE
from fieldkit.openrocket.design import Design, read_design

__all__ = ["MAX_UNPACKED_SIZE", "Design", "read_design"]
