"""What was known of a rocket before a flight was added, after any history of changes."""

from pathlib import Path
from tempfile import TemporaryDirectory

from hypothesis import example, given
from hypothesis import strategies as st

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger

ROCKETS = ("Astra", "Comet")
STEPS = st.lists(
    st.tuples(
        st.sampled_from(["add", "add", "edit", "rename", "tag", "remove", "undo", "redo", "accept"]),
        st.integers(0, 5),
        st.sampled_from(ROCKETS),
    ),
    min_size=1,
    max_size=14,
)


def states(ledger: Ledger) -> dict[str, tuple[tuple[Flight, ...], int]]:
    """The flights and the model version of each rocket."""
    return {
        rocket: (tuple(ledger.flights(rocket)), used.number if (used := ledger.active_version(rocket)) else 0)
        for rocket in ROCKETS
    }


def step(ledger: Ledger, what: str, which: int, rocket: str, number: int) -> None:
    """Change the ledger once; a change of a flight that is not there does nothing."""
    every = ledger.flights()
    own = every[which % len(every)] if every else None
    if what == "add":
        ledger.add([Flight(str(number), rocket, apogee=100.0 + number, notes=f"n{number}")])
    elif what == "accept":
        ledger.keep_version(rocket, {"effect": "wind"})
    elif what in ("undo", "redo"):
        (ledger.undo if what == "undo" else ledger.redo)()
    elif own is not None and what == "edit":
        ledger.edit(f"{own.rocket}/{own.flight_id}", apogee=200.0 + number)
    elif own is not None and what == "rename":
        ledger.edit(f"{own.rocket}/{own.flight_id}", rocket=rocket)
    elif own is not None and what == "tag":
        ledger.tag(f"{own.rocket}/{own.flight_id}", f"t{number}")
    elif own is not None and what == "remove":
        ledger.remove(f"{own.rocket}/{own.flight_id}")


@given(STEPS)
@example([("add", 0, "Astra"), ("add", 0, "Astra"), ("remove", 0, "Astra"), ("undo", 0, "Astra")])
def test_the_state_before_a_flight_is_the_one_that_was_there(steps: list[tuple[str, int, str]]) -> None:
    before: dict[str, dict[str, tuple[tuple[Flight, ...], int]]] = {}
    with TemporaryDirectory() as folder, Ledger.open(str(Path(folder) / "ledger.db")) as ledger:
        for number, (what, which, rocket) in enumerate(steps):
            was, there = states(ledger), {one.notes for one in ledger.flights()}
            try:
                step(ledger, what, which, rocket, number)
            except LedgerError:  # nothing to undo, or another flight has the name
                continue
            for one in ledger.flights():
                if one.notes not in there and (what != "undo" or one.notes not in before):
                    before[one.notes] = was
        flights = ledger.flights()
        for one, past in zip(flights, ledger.before(flights), strict=True):
            assert (past.flights, past.version) == before[one.notes][one.rocket]
