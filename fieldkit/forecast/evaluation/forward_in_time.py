"""How good forecasts are, forward in time: each flight of a rocket forecast from those it had flown before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.conformal import stretch, stretched, surprise
from fieldkit.forecast.predict import predict
from fieldkit.forecast.prediction import apart
from fieldkit.motors import Found
from fieldkit.progress import Tell, untold
from fieldkit.selection.candidates import Place
from fieldkit.shapes import Array, Float

DRAWS = 400


@dataclass(frozen=True, slots=True)
class Forecast:
    """One flight beside what was said of it before it flew, and what four rivals would have said. [m]

    `certified` is the simulation with the priors of a rocket never flown, `persistence` the apogee of the flight
    before, `repeated` that of the last flight on the same motor, `scaled` the certified one times one plus the mean
    relative bias so far. nan where a rival has nothing to go by. `corrected` is the 90 % interval after
    `corrected_by_earlier`, by a factor `stretch`; both None while too few forecasts came before. `draws` are of the
    forecast as it is given, None where they were not kept; `spreads` those of rivals that have a spread.
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
    draws: Float[Array, "draw"] | None = field(default=None, repr=False, compare=False)
    spreads: Mapping[str, Float[Array, "_"]] = field(default_factory=dict, repr=False, compare=False)

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
    tell: Tell = untold,
) -> list[Forecast]:
    """A forecast of every clean flight with an apogee, each from the flights before it; the first has none."""
    rows: list[Forecast] = []
    clean = [n for n, (flight, _) in enumerate(flown) if flight.clean and flight.apogee is not None]
    simulated = certified([flown[n] for n in clean])
    for place, number in enumerate(clean[1:], start=1):
        flight, motor = flown[number]
        tell(f"{rocket} {flight.flight_id}", number / len(flown))
        (said,) = predict(flown[:number], [(unflown(flight), motor)], accepted, draws=DRAWS)
        earlier = [(*flown[n], sim) for n, sim in zip(clean[:place], simulated, strict=False)]
        rows.append(
            beside_rivals(flight, motor, said.apogee, simulated[place], earlier, tuple(said.apogee_quantiles()))
        )
    return rows


def unflown(flight: Flight) -> Flight:
    """A flight as it was planned: without its readouts."""
    return flight.with_changes(**dict.fromkeys(flight.readouts()))


def certified(flights: Sequence[tuple[Flight, Found]]) -> list[Float[Array, "draw"]]:
    """The apogees of plans as the uncalibrated simulation has them: certified motors, the drag of any rocket. [m]"""
    if not flights:
        return []
    blind = predict([], [(unflown(flight), motor) for flight, motor in flights], draws=DRAWS)
    return [one.apogee for one in blind]


def beside_rivals(
    flight: Flight,
    motor: Found,
    draws: Float[Array, "draw"],
    simulated: Float[Array, "simulated"],
    earlier: Sequence[tuple[Flight, Found, Float[Array, "simulated"]]],
    interval: tuple[float, float, float],
) -> Forecast:
    """A flight beside its forecast and what the rivals make of the earlier flights, each with its simulation.

    The scalar correction is given the scatter of its own ratios as a spread, once there are three.
    """
    assert flight.apogee is not None
    middle = float(np.median(simulated))
    known = [(one.apogee or np.nan, float(np.median(sim))) for one, _, sim in earlier]
    ratios = np.array([high / sim for high, sim in known if sim > 0])
    factor = float(ratios.mean()) if len(ratios) else float("nan")
    same = [one.apogee for one, other, _ in earlier if other.motor is motor.motor and one.apogee is not None]
    spreads = {"certified": simulated}
    if len(ratios) > 2 and middle > 0:
        spreads["scaled"] = middle * factor * _next_ratio(ratios)
    return Forecast(
        flight.rocket,
        flight.flight_id,
        flight.motor,
        len(known),
        flight.apogee,
        float(interval[0]),
        float(interval[1]),
        float(interval[2]),
        certified=middle,
        persistence=known[-1][0] if known else float("nan"),
        scaled=middle * factor,
        repeated=same[-1] if same else float("nan"),
        when=flight.date_time,
        draws=draws,
        spreads=spreads,
    )


def _next_ratio(ratios: Float[Array, "flight"]) -> Float[Array, "draw"]:
    """Equally likely values of the next ratio over the mean one, its logarithm normal about a mean not known. [1]"""
    from scipy.special import ndtri

    sd = np.log(ratios).std(ddof=1) * np.sqrt(1 + 1 / len(ratios))
    return np.asarray(np.exp(sd * ndtri((np.arange(DRAWS) + 0.5) / DRAWS)))


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
            draws = None if row.draws is None else apart(row.draws, by)
            row = replace(row, stretch=by, corrected=(low, high), draws=draws)
        found.append(row)
        surprises.append(surprise(row.flown, row.interval))
    return found


def corrected_shares(rows: Sequence[Forecast]) -> dict[str, float | None] | None:
    """Coverage of the intervals that earlier flights corrected, and of the model's own for the same flights. [1]"""
    later = [row for row in rows if row.corrected]
    if not later:
        return None
    own = [row.p05 <= row.flown <= row.p95 for row in later]
    shares = {"coverage90": sum(row.inside for row in later) / len(later), "own_coverage90": sum(own) / len(later)}
    return {"flights": len(later), **shares, "last_stretch": later[-1].stretch}


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
    ways |= {"scaled to earlier flights": "scaled"}
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
