"""The app as a state machine: keys, pages and another program's changes in any order, shrunk to a minimal example.

In every state there are no unexpected errors, the app runs, and its ledger is sound.
"""

import asyncio
import shutil
import sys
from pathlib import Path
from tempfile import mkdtemp

import pytest
from hypothesis import HealthCheck, seed, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test
from textual.events import Key

from fieldkit.errors import LedgerError
from fieldkit.ledger import Ledger
from fieldkit.tui.app import FieldkitApp
from tests.pressing import season
from tests.tui.random_keys import LETTERS, NAMED, OTHER

SEEDS = (1, 2, 3)
"""Seeds that found bugs."""
PAUSE = 0.02
"""Between two keys. [s]"""


class Keys(RuleBasedStateMachine):
    """One app on a season; keys go to it as fast as a hand can press them."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(mkdtemp())
        self.file = self.folder / "ledger.db"
        season(self.file)
        self.app = FieldkitApp(self.file, self.folder / "settings.json")
        self.runner = asyncio.Runner()
        self.shown = self.app.run_test(size=(80, 24))
        self.pilot = self.runner.run(self.shown.__aenter__())

    def teardown(self) -> None:
        """Leave the app; unfinished work ends with it."""
        for worker in self.app.workers:
            worker.cancel()
        self.runner.run(self.shown.__aexit__(None, None, None))
        self.runner.close()
        shutil.rmtree(self.folder)

    async def _pressed(self, keys: list[str]) -> None:
        for key in keys:
            self.app.post_message(Key(key, key if len(key) == 1 else None))
            await self.pilot.pause(PAUSE)

    @rule(page=st.sampled_from("123456"))
    def turn_to(self, page: str) -> None:
        """Leave whatever is open, and turn to a page."""
        self.runner.run(self._pressed(["escape"] * 4 + [page]))

    @rule(keys=st.lists(st.sampled_from((*LETTERS, *NAMED)), min_size=1, max_size=8))
    def press(self, keys: list[str]) -> None:
        """Press a key of a page, a table or an input line."""
        self.runner.run(self._pressed(keys))

    @rule(key=st.sampled_from(OTHER), then=st.sampled_from(NAMED))
    def press_beside(self, key: str, then: str) -> None:
        """Press a key of the app itself, and another at once."""
        self.runner.run(self._pressed([key, then]))

    @rule(id=st.integers(1, 12), label=st.sampled_from(("mine", "off_axis")))
    def another_program_tags(self, id: int, label: str) -> None:
        """A command changes the ledger under the app."""
        self._beside(lambda ledger: ledger.tag(str(id), label))

    @rule(id=st.integers(1, 12))
    def another_program_removes(self, id: int) -> None:
        """A command removes a flight, which may be on the screen."""
        self._beside(lambda ledger: ledger.remove(str(id)))

    @rule()
    def another_program_undoes(self) -> None:
        """A command undoes the last change, which may be the app's."""
        self._beside(lambda ledger: ledger.undo())

    def _beside(self, change: object) -> None:
        assert callable(change)
        with Ledger.open(self.file) as ledger:
            try:
                change(ledger)
            except LedgerError:  # the flight is gone, or there is nothing to undo
                return
        self.runner.run(self._pressed(["escape"]))

    @invariant()
    def nobody_was_surprised(self) -> None:
        """No unexpected error, and the app runs."""
        assert self.app.errors == []
        assert self.app.place is None
        assert self.app.is_running

    @invariant()
    def the_ledger_is_sound(self) -> None:
        """It opens, each flight can be read, and the journal is in order."""
        with Ledger.open(self.file) as ledger:
            ledger.flights()
            numbers = [change.number for change in ledger.history()]
        assert numbers == list(range(1, len(numbers) + 1))


def run(number: int, examples: int, steps: int) -> None:
    """Try some runs of the machine that begin with a seed."""
    checks = settings(
        max_examples=examples, stateful_step_count=steps, deadline=None, suppress_health_check=list(HealthCheck)
    )
    run_state_machine_as_test(seed(number)(type("Seeded", (Keys,), {})), settings=checks)


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="a file that is open cannot be removed")
def test_a_few_steps_leave_the_app_in_a_valid_state() -> None:
    run(1, examples=1, steps=8)


@pytest.mark.slow
@pytest.mark.parametrize("number", SEEDS)
def test_any_steps_leave_the_app_in_a_valid_state(number: int) -> None:
    run(number, examples=15, steps=40)
