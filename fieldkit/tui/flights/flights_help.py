"""The help of the Flights page and of the view of a log: what their columns and figures mean."""

from fieldkit.tui.help import Help

FLIGHTS_HELP = Help(
    "Every flight in your ledger, newest first. Enter opens one: its readouts, its log, its drag and thrust, and its "
    "forecast. / and words list only the flights that match.",
    (
        ("/", "All words have to match: a rocket, a motor, a tag, a site, a month such as 2026-05."),
        (
            "id, date",
            "Its number in the ledger, and when it flew; a flight without a date is listed in the order entered.",
        ),
        ("rocket, cfg", "The rocket, its configuration, and its motor with the delay."),
        ("apogee", "Highest point above the pad, as your altimeter showed it."),
        ("Cd", "How much drag the rocket had in this flight, inferred from its readouts alone."),
        ("thrust", "Thrust factor (alpha) of the motor: 1 is as certified, 0.95 is five percent weaker."),
        (
            "miss",
            "Flown minus the forecast saved before the flight, ! outside its interval; with ~ against what the other "
            "flights lead to expect.",
        ),
        ("forecast ◆ ◎", "Forecast, flown ◆, target ◎ on one scale: ├─●─┤ is the 90% interval with the median."),
        ("miss*", "The forecast was stale: mass, motor, weather or model changed before the flight."),
        (
            "tags",
            "Anomalies. A flight with a tag such as weak_launch stays in the ledger but is not used in the model.",
        ),
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
LOG_HELP = Help(
    "The log from lift-off (T+0) to landing: height above the pad, speed and acceleration. The line at the top has the "
    "values at the cursor; below, or after Tab, are the facts.",
    (
        ("T+2.10 s", "Seconds from lift-off. In a log without a lift-off, seconds of its own clock."),
        ("Readouts", "Each with its standard deviation and sensor, and the device's own value if it states one."),
        ("Events", "Lift-off, burnout, apogee, ejection and landing: time, height, and the sensor that shows it."),
        ("How it was read", "The format, the reason for it, and the number of rows that were used."),
        ("Columns", "Each column of the file, its unit, and what it was read as."),
    ),
    ("fieldkit inspect FILE", "fieldkit report FLIGHT --out card.html"),
)
