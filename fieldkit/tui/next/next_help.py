"""The help of the Next page: what its columns, figures and signs mean."""

from fieldkit.tui.help import Help
from fieldkit.tui.next.next_plan import QUESTIONS

NEXT_HELP = Help(
    "Plan the next flight. The table lists every motor on sale that fits the rocket (no wider than the widest it has "
    "flown, and strong enough to lift it) with its forecast apogee; the forecast of the motor under the cursor is "
    "beside it. Type / and a name, a maker or a size such as 24mm to search the whole catalog; * lists all of it. "
    "With a target (g), the motors nearest to it come first. Press Enter to save a forecast; when you add the flight, "
    "the two are compared. Forecasts are advice: the range safety officer decides.",
    (
        ("apogee", "The apogee that your altimeter will show: the median of the forecast."),
        ("◆ ! ✗", "Before a motor: flown before, weak for this weight, not possible."),
        (
            "≈ apogee",
            "Not final: the network's answer, then a fit with few draws. The selected one is forecast in full.",
        ),
        ("off", "Forecast minus target, if you set one (g); the nearest motor comes first."),
        (
            "eject",
            "Seconds from apogee to ejection, for the delay that fires nearest to apogee; negative is before it.",
        ),
        ("by delay", "The same for each delay on sale."),
        ("├─●─┤", "With c: the 90% interval, all motors on one scale; ◎ is the target."),
        ("mm, N s", "Diameter and total impulse of the motor; c shows more columns."),
        ("delay", "The delay on sale that fires nearest to apogee."),
        (
            "✗ a motor",
            "Does not fit: too wide, too weak, slow off the rail, without a suitable delay, too high for the ceiling, "
            "or no longer made; its card says why.",
        ),
        ("90%", "Nine flights in ten should fall between these two."),
        (
            "hill",
            "The density of the forecast apogee: the higher, the likelier. The vertical lines are 5%, median and 95%.",
        ),
        (
            "true",
            "The true height above the pad. A barometric altimeter reads low on a hot day and high on a cold one.",
        ),
        ("ejection", "When the charge fires for each delay on sale, in seconds after apogee; negative is before it."),
        (
            "✓ ! ⊘ ?",
            "Safety checks: ok, caution, unsafe, unknown; each with its value and limit further down.",
        ),
        (
            "checks",
            "Rail exit speed, thrust to weight, ground wind, launch angle, ceiling, field size, ejection speed, motor "
            "temperature, distances to people and bystanders, mass, certification, legal class, whether the rocket is "
            "complex, misfire, and the sky.",
        ),
        ("off rail", "Speed at the end of the rail. If it is too low, the fins do not keep the rocket straight."),
        ("rail", "The same for every motor, with c."),
        ("top speed", "Top speed, at about burnout."),
        ("T:W", "Thrust over weight, in the first half second and on average: above 5 is good, below 3 is unsafe."),
        (
            "Cd, alpha",
            "Drag of the rocket and thrust of the motor used in the forecast, with their standard deviations.",
        ),
        (
            "air",
            "Air density at the pad, from the plan's weather; assumed values are named.",
        ),
        ("based on", "The flights and the model version behind the forecast."),
        (
            "narrows",
            "How much more flights like this would narrow the 90% interval; the rest is flight-to-flight variation.",
        ),
        *((question.title, question.help) for question in QUESTIONS),
    ),
    ("fieldkit predict --motor F24-4W --config A --wind 8mph", "fieldkit motors --fit ROCKET --target 800ft"),
)
