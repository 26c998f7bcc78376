"""fieldkit: from the altimeter's readouts to the next apogee."""

from pathlib import Path

from fieldkit.plugins import mount

mount()


def __getattr__(name: str) -> str:
    """`__version__`, looked up on first use: the lookup costs more than a small command."""
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version  # takes 22 ms to import

        try:
            return version("fieldkit")
        except PackageNotFoundError:  # a checkout that was never installed
            return _version_here()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _version_here() -> str:
    """The version in the project file next to this package, marked as that of a checkout, or that it is unknown."""
    import tomllib  # takes 12 ms to import

    try:
        project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        return f"{project['version']}+checkout"
    except (OSError, KeyError, tomllib.TOMLDecodeError):
        return "unknown version"
