"""OpenRocket designs (`.ork`): what a starting configuration needs, read as facts; never a flight."""

from fieldkit.openrocket.design import Design, read_design

__all__ = ["Design", "read_design"]
