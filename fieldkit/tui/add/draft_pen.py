"""Saves what is typed on the Add page: immediately and in order, independent of other workers."""

from asyncio import wrap_future
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial

from fieldkit.errors import FieldkitError
from fieldkit.tui.add.add_form import Draft
from fieldkit.tui.page import PageScreen


class DraftPen:
    """One thread that saves a draft; the page is notified once if it cannot be saved."""

    def __init__(self, page: PageScreen) -> None:
        self._page = page
        self._writer = ThreadPoolExecutor(1, "draft")
        self._unkept = ""

    def keep(self, draft: Draft, answers: Mapping[str, str], units: Mapping[str, str]) -> Future[None]:
        """Save a draft; it replaces one that is still waiting to be written."""
        kept = self._writer.submit(draft.keep, draft.flight, answers, units)
        self._page.run_worker(partial(self._report_unsaved, kept), exclusive=True, group="draft")  # type: ignore[arg-type]  # narrower than it takes
        return kept

    def finish(self) -> None:
        """Wait until the draft is written."""
        self._writer.shutdown()

    async def _report_unsaved(self, writing: Future[None]) -> None:
        before, self._unkept = self._unkept, ""
        try:
            await wrap_future(writing)
        except FieldkitError as error:
            self._unkept = str(error)
            if self._unkept != before:
                self._page.complain(f"What you type cannot be saved: {error}")
