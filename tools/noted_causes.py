"""`python tools/noted_causes.py LEDGER`: the causes that notes of flights state, beside those found in their readouts.

Every flight is compared with the others of its rocket. A note states a cause if it has one of the words below; it is
right if the most probable cause of the flight is among those of its note. A flight whose note states none is named if
one cause has more than half of the probability.
"""

import re
import sys

from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.presentation.one_off_text import why
from fieldkit.services.one_offs import flights_beside_others

WORDS = {
    r"horizontal|big arc|\barc(ed)?\b|into the wind|weathercock|off.axis|off.vertical": {"arc"},
    r"old motor|weak|slow take.?off|chuff|underpower|didn.t work": {"weak_motor", "other_motor", "arc"},
    r"eject\w* (went )?early|early eject": {"early_ejection"},
    r"late eject|eject\w* (went )?late": {"late_ejection"},
    r"extra drag|lost (a )?fin|fin came off|streamer|brake": {"extra_drag"},
}
"""Words of notes, and the causes that they state."""
NAMED = 0.5
"""Probability of one cause above which a flight is named. [1]"""


def causes_in(notes: str) -> set[str]:
    """The causes that a note states."""
    return {cause for words, causes in WORDS.items() if re.search(words, notes, re.IGNORECASE) for cause in causes}


def main(path: str) -> None:
    """Print the flights whose notes state a cause and those that are named, and how many are right."""
    right, noted, named, others = 0, 0, 0, 0
    with Ledger.open(path) as ledger:
        motors = catalogue()
        for rocket in ledger.names("rocket"):
            for one in flights_beside_others(ledger, motors, rocket):
                if not one.departures:
                    continue
                causes, first = causes_in(one.flight.notes), one.causes[0]
                if causes:
                    noted += 1
                    right += first.cause in causes
                else:
                    others += 1
                    named += first.probability > NAMED
                if causes or first.probability > NAMED:
                    sys.stdout.write(f"{one.flight.notes or '-'} | {why(one)}\n")
    sys.stdout.write(f"cause right for {right} of {noted} flights whose note states one\n")
    sys.stdout.write(f"named: {named} of {others} others\n")


if __name__ == "__main__":
    main(sys.argv[1])
