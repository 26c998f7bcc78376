"""fieldkit: from the altimeter's readouts to the next apogee."""

from importlib.metadata import PackageNotFoundError, version

from fieldkit.shelf import mount

try:
    __version__ = version("fieldkit")
except PackageNotFoundError:  # a checkout that was never installed
    __version__ = "0"

mount()
