"""How good forecasts are, forward in time: each flight of a rocket forecast from those it had flown before."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.loop.candidates import Place
from fieldkit.loop.predict import predict
from fieldkit.motors import Found

DRAWS = 400


@dataclass(frozen=True, slots=True)
class Forecast:
    """One flight beside what was said of it before it flew, and what three rivals would have said. [m]

    `certified` is the simulation with the priors of a rocket never flown, `persistence` the apogee of the
    flight before, `scaled` the certified one times the mean ratio of flown to certified so far. nan where a
    rival has nothing to go by.
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


def forward(
    rocket: str,
    flown: Sequence[tuple[Flight, Found]],
    accepted: Sequence[Place] = (),
    tell: Callable[[str, float], None] | None = None,
) -> list[Forecast]:
    """A forecast of every clean flight with an apogee, each from the flights before it; the first has none."""
    rows: list[Forecast] = []
    known: list[tuple[float, float]] = []
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
                    certified * ratio,
                )
            )  # fmt: skip
        if certified > 0:
            known.append((flight.apogee, certified))
    return rows


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
    found = []
    for name, field in ways.items():
        error = np.array([getattr(row, field) for row in rows]) - truth
        share = np.abs(error) / truth
        found.append(
            Tally(
                name,
                len(rows),
                float(np.median(share)),
                float(share.mean()),
                float(np.abs(error).mean()),
                float(error.mean()),
            )
        )
    inside = [row.p05 <= row.flown <= row.p95 for row in rows]
    return found, float(np.mean(inside))
