"""`python tools/noted_causes.py LEDGER`: the causes that notes of flights state, beside those found in their readouts.

Every flight is compared with the others of its rocket. A note states a cause if it has one of the words below; it is
right if the most probable cause of the flight is among those of its note. A flight whose note states none is named if
one cause has more than half of the probability.
"""

import re
import sys
from typing import Any

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


def causes_found(ledger: Ledger) -> dict[str, Any]:
    """How many flights have a note that states a cause, how many of these causes are the most probable one or among the
    three most probable, how many other flights are named, and the sentences about those."""
    first, three, noted, others = 0, 0, 0, 0
    named: list[str] = []
    for rocket in ledger.names("rocket"):
        for one in flights_beside_others(ledger, catalogue(), rocket):
            if not one.departures:
                continue
            stated, found = causes_in(one.flight.notes), [cause.cause for cause in one.causes]
            if stated:
                noted, first, three = noted + 1, first + (found[0] in stated), three + bool(stated & {*found[:3]})
                sys.stdout.write(f"{one.flight.notes} | {why(one)}\n")
                continue
            others += 1
            if one.causes[0].probability > NAMED:
                named.append(why(one))
    return {"noted": noted, "first": first, "among_three": three, "others": others, "named": named}


def main(path: str) -> None:
    """Print the flights whose notes state a cause and those that are named, and how many are right."""
    with Ledger.open(path) as ledger:
        found = causes_found(ledger)
    sys.stdout.write("".join(f"- | {text}\n" for text in found["named"]))
    sys.stdout.write(f"cause right for {found['first']} of {found['noted']} flights whose note states one, ")
    sys.stdout.write(f"among the three most probable for {found['among_three']}\n")
    sys.stdout.write(f"named: {len(found['named'])} of {found['others']} others\n")


if __name__ == "__main__":
    main(sys.argv[1])
