"""The Home page."""

from fieldkit.tui.page import Page

PAGE = Page(0, "Home", "fieldkit.tui.home.home_page:HomeScreen")
