"""The sample logs, and a small catalog of motors."""

from pathlib import Path

SAMPLES = sorted((Path(__file__).parent.parent / "sample_logs").iterdir())


def any_motor(name: str) -> str | None:
    """A catalog with every motor but one."""
    return f"found {name!r}, expected a motor of the catalog" if name == "ZZ99-1" else None


def owner(sample: Path) -> str:
    """The parser a sample was made for, by its name."""
    return sample.name.split("__")[0]
