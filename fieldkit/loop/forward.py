"""How good forecasts are, forward in time: each flight of a rocket forecast from those it had flown before."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from fieldkit.flight import Flight
from fieldkit.loop.candidates import Place
from fieldkit.loop.conformal import stretch, stretched, surprise
from fieldkit.loop.predict import predict
from fieldkit.motors import Found, Motor

DRAWS = 400


@dataclass(frozen=True, slots=True)
class Forecast:
    """One flight beside what was said of it before it flew, and what four rivals would have said. [m]

    `certified` is the simulation with the priors of a rocket never flown, `persistence` the apogee of the flight
    before, `repeated` that of the last flight on the same motor, `scaled` the certified one times the mean ratio of
    flown to certified so far. nan where a rival has nothing to go by. `corrected` is the 90 % interval after
    `corrected_by_earlier`, by a factor `stretch`; both None while too few forecasts came before.
    """

    rocket: str
    flight_id: str
    motor: str
    earlier: int
    flown: float
    p05: float
    p50: float
    p95: float
    certified: float
    persistence: float
    scaled: float
    repeated: float = float("nan")
    when: datetime | None = None
    stretch: float | None = None
    corrected: tuple[float, float] | None = None

    @property
    def interval(self) -> tuple[float, float, float]:
        """The model's own quantiles at 5, 50 and 95 %. [m]"""
        return self.p05, self.p50, self.p95

    @property
    def inside(self) -> bool:
        """Whether the flight came to lie in the 90 % interval that was given for it."""
        low, high = self.corrected or (self.p05, self.p95)
        return low <= self.flown <= high


def forward(
    rocket: str,
    flown: Sequence[tuple[Flight, Found]],
    accepted: Sequence[Place] = (),
    tell: Callable[[str, float], None] | None = None,
) -> list[Forecast]:
    """A forecast of every clean flight with an apogee, each from the flights before it; the first has none."""
    rows: list[Forecast] = []
    known: list[tuple[float, float]] = []
    repeated: dict[Motor, float] = {}
    for number, (flight, motor) in enumerate(flown):
        if not flight.clean or flight.apogee is None:
            continue
        plan = flight.with_changes(**dict.fromkeys(flight.readouts()))
        (blind,) = predict([], [(plan, motor)], draws=DRAWS)
        certified = float(np.median(blind.apogee))
        if known:
            if tell:
                tell(f"{rocket} {flight.flight_id}", number / len(flown))
            (said,) = predict(flown[:number], [(plan, motor)], accepted, draws=DRAWS)
            p05, p50, p95 = (float(x) for x in said.apogee_quantiles())
            ratio = float(np.exp(np.mean([np.log(high / sim) for high, sim in known])))
            last = known[-1][0]
            rows.append(
                Forecast(
                    rocket, flight.flight_id, flight.motor, len(known), flight.apogee, p05, p50, p95, certified, last,
                    certified * ratio, repeated.get(motor.motor, float("nan")), flight.date_time,
                )
            )  # fmt: skip
        repeated[motor.motor] = flight.apogee
        if certified > 0:
            known.append((flight.apogee, certified))
    return rows


def corrected_by_earlier(rows: Sequence[Forecast]) -> list[Forecast]:
    """The forecasts in the order flown, each interval corrected by how those of earlier flights fared.

    A flight counts as earlier only if it flew before; without dates the order given stands. The correction is by
    the forecasts of all of the flyer's rockets, for one rocket rarely has enough.
    """
    first = datetime.min
    ordered = sorted(rows, key=lambda row: row.when or first)
    found: list[Forecast] = []
    surprises: list[float] = []
    for row in ordered:
        by = stretch(surprises)
        if by is not None:
            low, _, high = stretched(row.interval, by)
            row = replace(row, stretch=by, corrected=(low, high))
        found.append(row)
        surprises.append(surprise(row.flown, row.interval))
    return found


@dataclass(frozen=True, slots=True)
class Tally:
    """Errors of one way to forecast, as shares of the apogee flown and in metres."""

    name: str
    flights: int
    median_share: float
    mean_share: float
    mae: float
    bias: float


def tally(rows: Sequence[Forecast]) -> tuple[list[Tally], float]:
    """The errors of the forecasts and of their rivals on the same flights, and the share in the 90 % interval."""
    truth = np.array([row.flown for row in rows])
    ways = {"fieldkit": "p50", "certified motor, no flights": "certified", "the flight before": "persistence"}
    ways |= {"certified, scaled to earlier flights": "scaled"}
    errors = {name: np.array([getattr(row, field) for row in rows]) - truth for name, field in ways.items()}
    repeats = np.array([row.repeated for row in rows]) - truth
    if np.isfinite(repeats).any():
        errors["the last flight on the same motor"] = repeats
        errors["fieldkit, where there is one"] = np.where(np.isnan(repeats), np.nan, errors["fieldkit"])
    found = []
    for name, error in errors.items():
        share = np.abs(error) / truth
        found.append(
            Tally(
                name,
                int(np.isfinite(error).sum()),
                float(np.nanmedian(share)),
                float(np.nanmean(share)),
                float(np.nanmean(np.abs(error))),
                float(np.nanmean(error)),
            )
        )
    return found, float(np.mean([row.inside for row in rows]))
