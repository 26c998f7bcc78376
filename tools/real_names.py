"""`python -m tools.real_names LEDGER...`: what the loop names on real rockets, one row each.

Every rocket with at least four usable flights; nothing is saved. `certain` are names at 80% or more.
"""

import sys

from fieldkit.errors import FieldkitError
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.selection.prior import UNEXPLAINED
from fieldkit.services.close_loop import diagnosis_of
from tools.markdown import table

NAMED, CERTAIN = 0.7, 0.8
"""Probabilities from which a name counts. [1]"""


def main(paths: list[str]) -> None:
    """Print the verdict for each rocket, and how many have a name."""
    rows: list[tuple[str, ...]] = []
    named = certain = 0
    motors = catalogue()
    for path in paths:
        with Ledger.open(path) as ledger:
            for rocket in ledger.names("rocket"):
                try:
                    found = diagnosis_of(ledger, motors, rocket)
                except FieldkitError:  # too few flights
                    continue
                verdict = found.verdict
                if verdict.effect not in ("none", UNEXPLAINED):
                    named += verdict.confidence >= NAMED
                    certain += verdict.confidence >= CERTAIN
                used = int(found.data.seen[:, 0].sum())
                miss = f"{found.before.mae:.1f} to {found.after.mae:.1f}"
                rows.append(
                    (rocket, str(used), verdict.effect, f"{verdict.confidence:.0%}", f"{found.fits.p:.2f}", miss)
                )
                sys.stderr.write(f"{rocket}\n")
    headers = ("rocket", "flights", "verdict", "probability", "p of what is left", "left-out error [m]")
    sys.stdout.write("\n".join(table(headers, rows)) + "\n")
    sys.stdout.write(f"\nNamed at {NAMED:.0%} or more: {named} of {len(rows)}; at {CERTAIN:.0%} or more: {certain}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
