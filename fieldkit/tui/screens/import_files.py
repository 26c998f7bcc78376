"""The Import page."""

from fieldkit.tui.page import Page

PAGE = Page(3, "Import", "fieldkit.tui.imports.import_page:ImportScreen")
