"""The help of the page Import: what its columns and keys mean."""

from fieldkit.tui.help import Help

IMPORT_HELP = Help(
    "Choose a log or a flight table. While the cursor stands on a file, it is read and nothing is stored: you see "
    "what it was recognized as, how many flights it would bring, each row that would be left out, with the "
    "reason, and the flights with what was read of them. Enter stores it. What is in the ledger already changes "
    "nothing, so a file may be imported twice. The space bar marks files that are read together, such as the logs "
    "of several altimeters in one flight.",
    (
        ("format", "The parser that recognised the file, by what is in it. F names another one."),
        (
            "look",
            "L draws the flight from lift-off with a cursor, and lists columns, readouts, events, what is stored.",
        ),
        ("rejected", "Rows that cannot become flights: mend them in the file and import it again."),
        (
            "columns",
            "m asks which column of a table is what; M lists what was named before, to change or forget it.",
        ),
        ("edit", "What the file leaves open, such as the rocket and its mass, for every flight in it."),
        (
            "design",
            "An OpenRocket file brings no flight: its mass, diameter and Cd are where a rocket starts from.",
        ),
    ),
    (
        "fieldkit import FILE ... --dry-run",
        "fieldkit import FILE --format NAME --set rocket=Astra --map 'altitude=Alt (ft)'",
        "fieldkit ork FILE.ork --rocket Lark --config A",
    ),
)
