"""The help of the Add page."""

from fieldkit.importing.manual_entry import QUESTIONS
from fieldkit.tui.help import Help

ABOUT = Help(
    "Type what your altimeter shows, in its order. Enter goes to the next field, the up arrow to the one before. A "
    "number may have a unit (923ft, 281.3 m, 140mph); without one it is in the unit beside the field. A typed unit "
    "also applies to the next flight. Esc, then N, switches to feet, mph and ounces, and back. A lone - means not "
    "recorded. Implausible figures are marked with ! and accepted. Everything you type is saved, so a dead battery "
    "loses nothing.",
    tuple((question.title, question.help) for question in QUESTIONS),
    ("fieldkit add", "fieldkit add --rocket R --motor M --apogee 935ft"),
)
