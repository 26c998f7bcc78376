"""Drag and thrust of a ledger's flights, each under its number in the ledger."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fieldkit.errors import NoFlights
from fieldkit.inference.network.flights import Inferred, Model, infer
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue


@dataclass(frozen=True, slots=True)
class InferredFlights:
    """What was inferred, the number of each flight with it, and why others were left out."""

    inferred: Sequence[Inferred]
    ids: Sequence[str]
    left_out: Sequence[str]

    def warnings(self) -> Iterator[tuple[str, list[str]]]:
        """Every warning, and the flights that it is of."""
        for warning in dict.fromkeys(line for one in self.inferred for line in one.warnings):
            yield warning, [id for id, one in zip(self.ids, self.inferred, strict=True) if warning in one.warnings]


def infer_flights(ledger: Ledger, motors: Catalogue, ids: Sequence[str], model: Model) -> InferredFlights:
    """Ask an ensemble for flights of a ledger, by default all. Raises NoFlights."""
    flights = ledger.flights(ids=ids or None)
    names = dict(zip(map(id, flights), ledger.ids(flights), strict=True))
    if not flights:
        raise NoFlights(f"{ledger.name}: found no flights, expected at least one; import or add flights first")
    found = infer(flights, motors, model)
    return InferredFlights(found.inferred, [names[id(one.flight)] for one in found.inferred], found.left_out)
