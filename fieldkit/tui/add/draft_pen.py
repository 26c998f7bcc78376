"""What writes the keys of the page Add down: at once, in order, whatever other workers are busy with."""

from asyncio import wrap_future
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial

from fieldkit.errors import FieldkitError
from fieldkit.tui.add.add_form import Draft
from fieldkit.tui.page import PageScreen


class DraftPen:
    """One thread that keeps a draft; a page hears once why keys cannot be kept, if they cannot."""

    def __init__(self, page: PageScreen) -> None:
        self._page = page
        self._writer = ThreadPoolExecutor(1, "draft")
        self._unkept = ""

    def keep(self, draft: Draft, answers: Mapping[str, str], units: Mapping[str, str]) -> Future[None]:
        """Keep what was typed; a draft that still waits to be written makes room for it."""
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
