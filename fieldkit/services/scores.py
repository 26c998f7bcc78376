"""The quality of a ledger's forecasts: those saved before flights, and each flight forecast from the earlier ones."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from fieldkit.errors import LedgerError, NoFlights
from fieldkit.forecast.evaluation.comparison import ScoreReport, judged_report
from fieldkit.forecast.evaluation.forward_in_time import Forecast, corrected_coverage, next_weights
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.progress import ReportProgress, no_op
from fieldkit.services.forecasts import keep_forecasts, which_rocket
from fieldkit.services.saved_forecasts import list_forecasts
from fieldkit.services.track_record import read_hyperprior, record, replayed


@dataclass(frozen=True, slots=True)
class LedgerScores:
    """Scores of saved forecasts (None if there are none; `stale` counts those whose inputs have changed), of replayed
    flights after earlier ones of their rocket, and of first flights; the stacking weights of the next forecast, of a
    rocket that has flown and of a first flight, and the coverage of corrected intervals.

    `unsaved` is why the replayed forecasts were not saved, None if they were or need not be."""

    saved: ScoreReport | None
    stale: int
    later: ScoreReport
    first: ScoreReport
    weights: dict[str, float]
    weights_of_first: dict[str, float]
    corrected: Mapping[str, Any] | None
    unsaved: LedgerError | None = None


def score_forecasts(
    ledger: Ledger,
    motors: Catalogue,
    rocket: str | None = None,
    hyperprior: Path | None = None,
    on_progress: ReportProgress = no_op,
    *,
    since: date | None = None,
) -> LedgerScores:
    """Score a ledger's forecasts, of one rocket or of all, of flights since a day or without a date; with the
    hyperprior of a card nothing is saved.

    Earlier flights still inform the forecasts, their corrections and the stacking weights.

    Raises NoFlights, and BadValue or DamagedModel for a card that cannot be read.
    """
    other = read_hyperprior(hyperprior) if hyperprior else None
    name = which_rocket(ledger, rocket) if rocket else None
    made = [one for one in list_forecasts(ledger, motors) if name in (None, one.made.rocket)]
    before = _since(record(ledger, motors, made), since)
    rows = replayed(ledger, motors, name, hyperprior=other, on_progress=on_progress)
    unsaved = _unsaved(ledger, rows) if other is None else None
    judged = _since(rows, since)
    if not judged:
        limit = f" since {since}" if since else ""
        raise NoFlights(f"found no normal flight with an apogee and a dry mass{limit}, expected at least one")
    later, first = (judged_report([row for row in judged if bool(row.earlier) == known]) for known in (True, False))
    return LedgerScores(
        judged_report(before) if before else None,
        sum(one.stale for one in made if one.flown is not None),
        later,
        first,
        next_weights(rows),
        next_weights(rows, first=True),
        corrected_coverage(rows),
        unsaved,
    )


def _unsaved(ledger: Ledger, rows: Sequence[Forecast]) -> LedgerError | None:
    """Save the replayed forecasts; or return why not: the scores do not depend on a full or read-only disk."""
    try:
        keep_forecasts(ledger, rows)
    except LedgerError as error:
        return error
    return None


def _since(rows: Sequence[Forecast], day: date | None) -> list[Forecast]:
    return [row for row in rows if day is None or row.when is None or row.when.date() >= day]
