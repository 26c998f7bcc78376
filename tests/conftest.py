"""Annotated shapes are checked in tests; ordinary runs have no cost.

Checks take two to four times the run time of the engine, so test modules of whole runs turn them off
(`CHECK_SHAPES = False`); the functions they call are checked in other modules, or in a test with `shapes_checked`.
"""

import gc
import importlib
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is imported; two workers would fight for the cores

import jaxtyping
import pytest
from hypothesis import settings
from jaxtyping import install_import_hook

from tests import checker
from tests.cached import once
from tests.commands import run as run  # a fixture
from tests.effort import THOROUGH, left_out

ROOT = Path(__file__).parents[1]
CHECKED = (
    "fieldkit/physics",
    "fieldkit/motors",
    "fieldkit/model",
    "fieldkit/inference",
    "fieldkit/scoring",
    "fieldkit/selection",
    "fieldkit/forecast",
    "fieldkit/planning",
    "fieldkit/reference",
    "fieldkit/services",
    "fieldkit/presentation",
    "studies",
)
SHAPE = re.compile(r"\b(Float|Int|Bool)\[")


def with_shapes() -> list[str]:
    """The modules with annotated shapes; checking the types of the others would take seconds, and mypy does it."""
    files = [file for folder in CHECKED for file in (ROOT / folder).rglob("*.py")]
    named = [file for file in files if SHAPE.search(file.read_text(encoding="utf-8"))]
    return [".".join(file.relative_to(ROOT).with_suffix("").parts) for file in named]


CHECKING = "--benchmark-only" not in sys.argv  # checks would slow what is measured
with patch.dict(os.environ, {"FIELDKIT_CHECK_SHAPES": "1" if CHECKING else ""}):
    importlib.import_module("fieldkit.shapes")  # reads the variable; child processes of tests must not find one

if CHECKING:
    install_import_hook(with_shapes(), f"{checker.__name__}.{checker.check.__name__}")

gc.set_threshold(20_000, 20, 50)  # the garbage collector would take a seventh of the time scanning libraries

# a busy machine is not a failure of the code
settings.register_profile("fieldkit", deadline=None, max_examples=100 if THOROUGH else 25)
settings.load_profile("fieldkit")


def pytest_configure(config: pytest.Config) -> None:
    """`-m fast` replaces the default `-m 'not slow and not thorough'`, but long tests are still left out; the thorough
    run has them too."""
    if config.option.markexpr == "fast":
        config.option.markexpr = "fast and not slow and not thorough"
    elif THOROUGH and config.option.markexpr == "not slow and not thorough":
        config.option.markexpr = "not slow"


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """A run that is not thorough and names no cases tries a quarter of those of each test marked `sampled`."""
    if not (THOROUGH or config.option.keyword or any("::" in place for place in config.args)):
        out = left_out(items)
        config.hook.pytest_deselected(items=[item for item in items if item in out])
        items[:] = [item for item in items if item not in out]


def pytest_collection_finish() -> None:
    """Libraries, modules and tests stay to the end: no collection of garbage scans them again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test touches the ledger, the motors or the settings of the user who runs it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FIELDKIT_HOME", str(tmp_path_factory.mktemp("home")))
        patch.delenv("FIELDKIT_LEDGER", raising=False)
        yield


@pytest.fixture(scope="session", autouse=True)
def _files_quickly_made_and_written() -> Iterator[None]:
    """The migrations, most of the time that a new ledger takes, run once, and no change waits for the disk, 20 ms each:
    only a power failure would show the difference."""
    from tests.new_ledgers import upgrade

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fieldkit.ledger.opening.upgrade", upgrade)
        patch.setattr("fieldkit.ledger.opening.SYNCHRONOUS_MODE", "OFF")
        patch.setattr(os, "fsync", lambda _: None)
        yield


@pytest.fixture(scope="session", autouse=True)
def _measured_once() -> Iterator[None]:
    """Logs with equal samples are measured once when they are imported; tests of `analysis` call `measure` itself."""
    from fieldkit.analysis import measure

    with pytest.MonkeyPatch.context() as patch:
        measured = once(measure)
        patch.setattr("fieldkit.importing.from_samples.measure", measured)
        patch.setattr("fieldkit.services.replay.measure", measured)
        yield


@pytest.fixture(scope="module", autouse=True)
def _shapes(request: pytest.FixtureRequest) -> Iterator[None]:
    """Shapes are checked in this module, unless it turns the checks off."""
    jaxtyping.config.update("jaxtyping_disable", not getattr(request.module, "CHECK_SHAPES", True))
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.fixture
def shapes_checked() -> Iterator[None]:
    """Shapes are checked in this test of a module that turns the checks off."""
    with patch.object(jaxtyping.config, "jaxtyping_disable", False):
        yield
