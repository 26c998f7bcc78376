"""What the page Add explains."""

from fieldkit.importing.manual_entry import QUESTIONS
from fieldkit.tui.help import Help

ABOUT = Help(
    "Type what your altimeter shows, in its order; Enter goes on, the arrow up goes back. A unit may follow the "
    "number (923ft, 281.3 m, 140mph); without one the unit beside the field applies, and a typed unit also applies "
    "to the next flight. A lone - means not recorded. Implausible figures are marked with ! and accepted. All "
    "keys are saved: after a dead battery the form is as you left it.",
    tuple((question.title, question.help) for question in QUESTIONS),
    ("fieldkit add", "fieldkit add --rocket R --motor M --apogee 935ft"),
)
