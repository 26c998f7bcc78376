"""OpenRocket designs (`.ork`): what a starting configuration needs, read as facts; never a flight."""

from fieldkit.openrocket.archive import MOST
from fieldkit.openrocket.design import Design, read_design

__all__ = ["MOST", "Design", "read_design"]
