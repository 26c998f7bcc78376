"""The Setup page."""

from fieldkit.tui.page import Page

PAGE = Page(6, "Setup", "fieldkit.tui.setup.setup_page:SetupScreen")
