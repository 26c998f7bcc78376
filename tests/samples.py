"""The sample logs, and a small catalog of motors."""

from pathlib import Path

SAMPLES = sorted((Path(__file__).parent.parent / "sample_logs").iterdir())


def any_motor(name: str) -> str | None:
    """A catalog with every motor but one."""
    return f"found {name!r}, expected a motor of the catalog" if name == "ZZ99-1" else None


def owner(sample: Path) -> str:
    """The parser a sample was made for, by its name."""
    return sample.name.split("__")[0]


def samples_of(parser: str) -> list[Path]:
    """The sample logs of a parser; a test fails that asks for those of one without any."""
    found = [sample for sample in SAMPLES if owner(sample) == parser]
    assert found, f"parsers/{parser}.py has no sample log; put one in sample_logs/{parser}__WHAT_HAPPENED.SUFFIX"
    return found
