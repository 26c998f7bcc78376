"""The help of the Setup page."""

from fieldkit.tui.help import Help

SETUP_HELP = Help(
    "Five lists; the left and right arrows, or a click, switch between them. Motors: the whole catalog; type / "
    "and a name to search it, press i to add your own .eng or .rse file. Rockets and sites come from your flights: "
    "press Enter to edit one in every flight that has it, u to undo; i adds a site before anything flies there. "
    "Kits: defaults for rockets named after a kit; "
    "i adds one, x removes one. Settings: press Enter to change a value.",
    (
        ("mm, N s, avg N", "Diameter, total impulse and average thrust of a motor."),
        ("burn s, grams", "Burn time of a motor, and its mass with propellant."),
        ("delays s", "Ejection delays on sale; P is plugged: no charge."),
        (
            "rocket, config",
            "A build of a rocket. Dry mass and diameter are those of its last flight.",
        ),
        ("last", "The last flight there, and for a build its last motor."),
        ("elevation", "Elevation of the site above sea level; air density depends on it and on the weather."),
        ("kit, mount", "A kit of yours, and the widest motor that its mount takes. Saved in kits.toml."),
        ("size, ceiling", "Size of the field, and its altitude limit."),
        (
            "units",
            "SI: meters and grams. US: feet and ounces. mixed: feet and grams. N changes them.",
        ),
        ("theme", "field: any room. sun: black on white. night: red on black. terminal: its own. T changes it."),
        ("target", "The target apogee for comparing motors on the Next page."),
        ("sites", "Field size and ceiling are used in the safety checks of every plan at the site."),
        ("rail", "Length and angle of your usual rail, for plans without one."),
    ),
    (
        "fieldkit motors F24",
        "fieldkit motors --import FILE.eng",
        "fieldkit edit FLIGHT dry_mass=330g",
        "fieldkit sites FIELD --size 400m",
        "fieldkit kits NAME --dry-mass 80g",
    ),
)
