"""The Loop page."""

from fieldkit.tui.page import Page

PAGE = Page(5, "Loop", "fieldkit.tui.loop.loop_page:LoopScreen")
