"""The Next page."""

from fieldkit.tui.page import Page

PAGE = Page(4, "Next", "fieldkit.tui.next.next_page:NextScreen")
