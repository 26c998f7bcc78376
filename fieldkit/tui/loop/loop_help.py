"""The help of the Loop page: what its panels mean."""

from fieldkit.tui.help import Help

LOOP_HELP = Help(
    "Test the model of a rocket on its own flights: each is forecast from the others, and the residuals are "
    "compared with those that known effects would cause (wind, weak motors, an altimeter that reads high). "
    "Press S to search, which takes a few seconds and changes nothing. Press A to accept the result, D to decline it. "
    "Under Versions, press Enter to switch to another model, and u to undo that.",
    (
        (
            "Verdict",
            "What is missing in one sentence, the mean miss of flights that were forecast from the others, before and "
            "after accepting it, and what to do next. Below: what several rockets share, searched after this one.",
        ),
        (
            "Flights",
            "Flights that differ from the others of the rocket, with the likely cause. Enter or t tags one with it, "
            "which leaves it out of every fit.",
        ),
        (
            "Evidence",
            "A level down: why, what it changes on the next flight, misses flight by flight, the odds, the flight that "
            "would decide, what accepting changes, and the error on held-out flights.",
        ),
        (
            "Residuals",
            "Flown minus forecast of each flight, in units of its expected scatter, against the column chosen "
            "with v. p is the probability of such a pattern by chance, corrected for the number of columns "
            "tested.",
        ),
        (
            "Fingerprint",
            "The residual that an effect (n for the next one) would cause in each readout, beside the one observed.",
        ),
        (
            "Ranking",
            "Effects, the most probable first. Chance: the probability that it is present, alone or with others. "
            "Evidence, for it alone: +3 is twenty to one for it, 0 is neutral, negative is against it. Below are the "
            "details of the one under the cursor; Enter for its fingerprint.",
        ),
        (
            "effect that S looks for, up to",
            "Before a search: each effect that it tries, and a strength that the effect rarely exceeds.",
        ),
        ("Versions", "Saved models of this rocket, and the one in use. 0 is the plain model."),
        ("no., made, adds", "Number of the version, its date, and the effects that it adds."),
        ("held-out error", "Its mean error on held-out flights, before and after."),
    ),
    (
        "fieldkit loop [--rocket R] [--dry-run] [--report FILE]",
        "fieldkit loop --fleet",
        "fieldkit model --use N",
        "fieldkit report ROCKET --out r.pdf",
    ),
)
