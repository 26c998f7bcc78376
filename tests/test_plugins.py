"""Plug-in folders are found next to the package in a checkout and inside it when installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.fast

ROOT = Path(__file__).parent.parent
LIST = "import fieldkit.importing.recognize as p, fieldkit.parsers as s; print(*p.parsers(), *s.__path__, sep='\\n')"
IDLE = "import sys, fieldkit.flight; print(*(m for m in sys.modules if m.startswith(('fieldkit.p', 'scipy'))))"


def run(code: str, folder: Path) -> list[str]:
    """The output lines of a new process with `folder` first on its path."""
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(folder)!r}); {code}"]
    return subprocess.run(command, cwd=folder.parent, capture_output=True, text=True, check=True).stdout.split()


def test_an_installed_package_finds_its_parsers_inside_itself(tmp_path: Path) -> None:
    skip = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "fieldkit", tmp_path / "site" / "fieldkit", ignore=skip)
    shutil.copytree(ROOT / "parsers", tmp_path / "site" / "fieldkit" / "parsers", ignore=skip)
    (tmp_path / "site" / "parsers").mkdir()
    (tmp_path / "site" / "parsers" / "stranger.py").write_text("raise SystemExit('not ours')")
    *names, folder = run(LIST, tmp_path / "site")
    assert names == sorted(path.stem for path in (ROOT / "parsers").glob("[!_]*.py"))
    assert Path(folder) == tmp_path / "site" / "fieldkit" / "parsers"


def test_a_checkout_finds_its_parsers_beside_the_package() -> None:
    *names, folder = run(LIST, ROOT)
    assert "flight_table" in names
    assert Path(folder) == ROOT / "parsers"


def test_mounting_plug_in_folders_imports_no_plug_in() -> None:
    assert set(run(IDLE, ROOT)) <= {"fieldkit.parsers", "fieldkit.plugins"}


@pytest.mark.parametrize("name", ["parsers", "models"])
def test_a_plugin_folder_is_not_an_ordinary_package(name: str) -> None:
    assert not (ROOT / name / "__init__.py").exists()
