"""The help of the Import page and of column mappings: what their columns and keys mean."""

from fieldkit.tui.help import Help

IMPORT_HELP = Help(
    "Choose a log or a table of flights. The file under the cursor is only shown; Enter imports it, and asks for its "
    "rocket and motor if it names none.",
    (
        ("twice", "Duplicates change nothing, so a file may be imported twice."),
        ("marked", "Space marks files to read together, such as the logs of several altimeters in one flight."),
        ("format", "The parser that recognized the file by its content. F to choose another one."),
        ("look", "l to plot the flight from lift-off, with a cursor, and to list columns, readouts and events."),
        ("rejected", "Rows that cannot become flights: fix them in the file and import it again."),
        ("columns", "m to map the columns of a table; M to change or remove saved mappings."),
        ("values", "e for values that the file lacks, such as the rocket and its mass, for every flight in it."),
        ("design", "A design (.ork, .rkt, .CDX1) adds no flight: mass, diameter and Cd are the start of a rocket."),
        (
            "weather",
            "Saved weather (Open-Meteo, Meteostat, METAR, winds aloft, tables) fills in the conditions of flights at "
            "its site by date and hour, each with its standard deviation; u undoes it.",
        ),
    ),
    (
        "fieldkit import FILE ... --dry-run",
        "fieldkit import FILE --format NAME --set rocket=Astra --map 'altitude=Alt (ft)'",
        "fieldkit ork FILE.ork --rocket Lark --config A",
        "fieldkit weather FILE --site Moor --timezone -5",
    ),
)
MAPPING_ABOUT = (
    "Name the column of the table that holds each value; leave empty what the table lacks. Names are offered as you "
    "type. Enter goes to the next field and saves after the last one. The mapping is saved, and used for every table "
    "with the same headings."
)
MAPPINGS_HELP = Help(
    "Every saved column mapping, listed by the headings of its table. A table with these headings is read by it. Enter "
    "changes its columns, x deletes it. m on the Import page makes a new one.",
    (
        ("of", "Whether each row of the table is a flight or a sample of a log."),
        ("columns", "Each value with the column it is read from, such as altitude=Alt (ft)."),
        ("headings of the table", "The headings by which a table is recognized."),
    ),
    ("fieldkit mappings", "fieldkit import FILE --map 'altitude=Alt (ft)'"),
)
