"""The help of the page Next: what its columns, figures and signs mean."""

from fieldkit.tui.help import Help
from fieldkit.tui.next.next_plan import QUESTIONS

NEXT_HELP = Help(
    "What the rocket would do next. The table holds every motor on sale that fits it (as wide as the widest it has "
    "flown, and strong enough to lift it), and where each would take it; move the cursor and the forecast follows. "
    "Type / and a name, a maker or a size such as 24mm to search the whole catalogue; * lists all of it. With a "
    "target set (g), the motors that come nearest to it are on top. Enter saves a forecast, and the flight is "
    "measured against it when you add it. Forecasts are advice: the range safety officer decides.",
    (
        ("apogee", "What your altimeter will show, in the middle of the distribution."),
        ("off", "Forecast less target, where there is one (g); the nearest motor stands first."),
        ("eject", "Seconds from apogee to ejection with the delay that fires nearest to it; - is before."),
        ("by delay", "The same for each delay on sale."),
        ("├─●─┤", "Under c: where nine flights of ten would end, all motors on one scale; ◎ is the target."),
        ("mm, N s", "Diameter and total impulse of the motor; under c, with all that is known of each motor."),
        ("delay", "The delay on sale that fires nearest to apogee."),
        ("✗ a motor", "Found by the search, and it does not fit: too wide, too weak, or no longer made."),
        ("90 %", "Nine flights of ten should end between these two."),
        ("hill", "How likely each apogee is: most where it is high. The upright lines are 5 %, middle and 95 %."),
        ("true", "The height in fact; on a hot day a barometric altimeter shows less than that, in the cold more."),
        ("ejection", "When the charge fires for each delay on sale, in seconds after apogee; - is before."),
        (
            "✓ ! ⊘ ?",
            "Safety checks: well, caution, unsafe, not known; each with its figures and limit further down.",
        ),
        (
            "checks",
            "Rail exit speed, thrust to weight, ground wind, launch angle, ceiling, field size, ejection speed, "
            "motor temperature, distances of people and bystanders, mass, certification, the class that the law "
            "puts the rocket in, whether it is complex, and what the sky must be.",
        ),
        ("off rail", "Speed at the end of the rail. Below 15 m/s fins may not hold the rocket straight."),
        ("rail", "The same for every motor, under c."),
        ("top speed", "The fastest it gets, at about burnout."),
        ("T:W", "Thrust over weight, first half second and average: 5 is good, below 3 is not safe."),
        ("Cd, alpha", "Drag of the rocket and thrust of the motor that the flight is forecast with, and how sure."),
        (
            "air",
            "Density of the air at the pad, from what the plan says of the weather; what it leaves open is named.",
        ),
        ("rests on", "The flights and the version of the model that the forecast is made from."),
        ("narrows", "What more such flights would take off the 90 %; the rest is how single flights differ."),
        *((question.title, question.help) for question in QUESTIONS),
    ),
    ("fieldkit predict --motor F24-4W --config A --wind 8mph", "fieldkit motors --fit ROCKET --target 800ft"),
)
