"""The help of the page Flights: what its columns mean."""

from fieldkit.tui.help import Help

FLIGHTS_HELP = Help(
    "Every flight of your ledger, the newest first. Type / and any words to see only flights that hold them all "
    "(a rocket, a motor, a tag, a site, a month such as 2026-05). Enter opens a flight: its readouts, its log, "
    "what it says of drag and thrust, and what was forecast for it.",
    (
        ("id, date", "Its number in the ledger, and when it flew; without a date it stands where it was entered."),
        ("rocket, cfg", "The rocket and its configuration; motor is what it flew on, with the delay."),
        ("apogee", "Highest point above the pad, as your altimeter showed it."),
        ("Cd", "How much drag the rocket had in this flight, inferred from its readouts alone."),
        ("alpha", "How hard the motor pushed: 1 is as certified, 0.95 is five percent weaker."),
        ("miss", "Flown less forecast, for the forecast that was made before it. Empty where none was made."),
        ("miss*", "The forecast was stale: mass, motor, weather or model had changed between it and the flight."),
        ("tags", "What was odd. A flight with a tag such as weak_launch stays and is left out of the fit."),
    ),
    (
        "fieldkit flights [--rocket R] [--tag T]",
        "fieldkit infer",
        "fieldkit tag FLIGHT TAG",
        "fieldkit remove FLIGHT",
        "fieldkit undo",
        "fieldkit report DAY --out day.html",
    ),
)
