"""fieldkit: from the altimeter's readouts to the next apogee."""

from fieldkit.shelf import mount

mount()


def __getattr__(name: str) -> str:
    """`__version__`, looked up when asked for: the look-up costs more than a small command."""
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("fieldkit")
        except PackageNotFoundError:  # a checkout that was never installed
            return "0"
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
