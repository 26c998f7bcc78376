"""The Capture page."""

from fieldkit.tui.page import Page

PAGE = Page(7, "Capture", "fieldkit.tui.imports.capture_page:CaptureScreen")
