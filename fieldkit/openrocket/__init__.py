"""Designs of OpenRocket (`.ork`), RockSim (`.rkt`) and RASAero (`.CDX1`): what a starting configuration needs, never a
flight."""

from fieldkit.openrocket.archive import MAX_UNPACKED_SIZE
from fieldkit.openrocket.design import Design, read_design

__all__ = ["MAX_UNPACKED_SIZE", "Design", "read_design"]
