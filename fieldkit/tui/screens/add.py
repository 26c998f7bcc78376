"""The Add page."""

from fieldkit.tui.page import Page

PAGE = Page(2, "Add", "fieldkit.tui.add.add_page:AddScreen")
