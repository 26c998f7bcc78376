"""The help of the Import page: what its columns and keys mean."""

from fieldkit.tui.help import Help

IMPORT_HELP = Help(
    "Choose a log or a flight table. The file under the cursor is read but not imported: you see its format, how "
    "many flights it would add, each rejected row with the reason, and the flights. Press Enter to import it; if it "
    "names no rocket or no motor, a form asks for them. "
    "Duplicates change nothing, so a file may be imported twice. Press the space bar to mark files that belong "
    "together, such as the logs of several altimeters in one flight.",
    (
        ("format", "The parser that recognized the file by its content. F to choose another one."),
        (
            "look",
            "l to plot the flight from lift-off, with a cursor, and to list columns, readouts and events.",
        ),
        ("rejected", "Rows that cannot become flights: fix them in the file and import it again."),
        (
            "columns",
            "m to map the columns of a table; M to change or remove saved mappings.",
        ),
        ("edit", "Values that the file lacks, such as the rocket and its mass, for every flight in it."),
        (
            "design",
            "An OpenRocket file adds no flight: its mass, diameter and Cd are the starting point of a rocket.",
        ),
    ),
    (
        "fieldkit import FILE ... --dry-run",
        "fieldkit import FILE --format NAME --set rocket=Astra --map 'altitude=Alt (ft)'",
        "fieldkit ork FILE.ork --rocket Lark --config A",
    ),
)
