"""The Fly page."""

from fieldkit.tui.page import Page

PAGE = Page(4, "Fly", "fieldkit.tui.next.next_page:NextScreen")
