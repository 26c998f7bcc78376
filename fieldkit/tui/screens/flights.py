"""The Flights page."""

from fieldkit.tui.page import Page

PAGE = Page(1, "Flights", "fieldkit.tui.flights.flights_page:FlightsScreen")
