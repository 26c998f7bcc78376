"""The marker `fast`: a sample of the tests that still covers every package, for the minute between two edits."""

from pathlib import Path

import pytest

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

ROOT = Path(__file__).parents[1]
PACKAGES = sorted(init.parent.relative_to(ROOT / "fieldkit") for init in (ROOT / "fieldkit").glob("*/__init__.py"))
PLUGINS = [Path("parsers"), Path("models"), Path("studies")]


@pytest.mark.parametrize("package", [*PACKAGES, *PLUGINS], ids=str)
def test_every_package_has_fast_tests(package: Path) -> None:
    modules = (ROOT / "tests" / package).rglob("test_*.py")
    assert any("mark.fast" in module.read_text(encoding="utf-8") for module in modules)


def test_the_packages_are_found() -> None:
    assert {"physics", "inference", "tui"} <= set(map(str, PACKAGES))
