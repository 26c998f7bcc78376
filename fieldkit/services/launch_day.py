"""The launch day: the plan of the next flight, the weather, the latest flights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date

from fieldkit.flight import MOTOR_TEMPERATURE, Flight
from fieldkit.flight.columns import WEATHER
from fieldkit.flight.recovery import STABILITY, recovery_header
from fieldkit.forecast.prediction import Prediction
from fieldkit.importing.manual_entry import answer_text, read_answer
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.services.day_weather import WEATHER_DRAFT, answer_texts, signed_now, typed_weather, weather_of
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.listed_flights import MAX_LISTED_FLIGHTS, ListedFlight
from fieldkit.services.manual_entry import waiting_plan
from fieldkit.services.plans import completed_plan, stated_bodies
from fieldkit.services.saved_forecasts import SavedForecast, by_flight, list_forecasts
from fieldkit.settings import Settings

FURTHER = (
    MOTOR_TEMPERATURE,
    STABILITY,
    *map(recovery_header, ("parachute_diameter", "main_speed", "drogue_speed", "main_altitude", "wind_aloft")),
)
"""The further columns of a plan that its form asks for."""
OF_THE_ROCKET = FURTHER[1:-1]
"""Those that belong to its rocket."""
PLAN_DRAFT = "plan"
"""Name under which the ledger saves the plan of the next flight."""


@dataclass(frozen=True, slots=True)
class Overview:
    """The launch day: the planned flight, today's weather as conditions, the open forecast, and the latest flights,
    newest first."""

    plan: Flight
    weather: Flight
    forecast: SavedForecast | None
    flights: tuple[ListedFlight, ...]

    @property
    def last(self) -> ListedFlight | None:
        """The last flight with an apogee."""
        return next((one for one in self.flights if one.flight.apogee is not None), None)

    def on(self, day: date) -> list[ListedFlight]:
        """The flights of a day, newest first."""
        return [one for one in self.flights if one.flight.date_time and one.flight.date_time.date() == day]


def save_plan(ledger: Ledger, texts: Mapping[str, str]) -> bool:
    """Save the plan of the next flight, its mass and diameter if no flight has them, and today's weather as one
    change; False if all are unchanged. Raises BadValue."""
    build = f"{texts.get('rocket', '')} {texts.get('config', '')}".strip()
    stated = stated_bodies(ledger, [Flight().with_changes(**plan_changes(texts))])
    return ledger.change_drafts(_plan_drafts(ledger, texts), "plan", build, stated)


def _plan_drafts(ledger: Ledger, texts: Mapping[str, str]) -> dict[str, dict[str, str]]:
    """What a plan changes in the ledger: the plan, and today's weather if it is different."""
    weather = {name: text for name, text in texts.items() if name in WEATHER}
    drafts = {PLAN_DRAFT: {name: text for name, text in texts.items() if name not in WEATHER}}
    return drafts | ({} if weather == typed_weather(ledger)[0] else {WEATHER_DRAFT: signed_now(weather)})


def mass_drafts(ledger: Ledger, dry_mass: float) -> dict[str, dict[str, str]]:
    """What a dry mass [kg] of the planned next flight changes in the ledger. Raises BadValue if the saved plan
    cannot be read.
    """
    mass = answer_text(Flight(dry_mass=dry_mass), "dry_mass")
    plan = planned(ledger, ledger.flights(last=MAX_LISTED_FLIGHTS)) or Flight()
    build = {"rocket": plan.rocket, "config": plan.config}
    kept = (ledger.draft(PLAN_DRAFT) or {}) | typed_weather(ledger)[0]
    return _plan_drafts(ledger, build | kept | {"dry_mass": mass})


def planned_mass(ledger: Ledger) -> float | None:
    """The dry mass of the saved plan of the next flight; None if it has none. [kg]

    Raises BadValue if it cannot be read.
    """
    text = (ledger.draft(PLAN_DRAFT) or {}).get("dry_mass", "")
    mass = plan_changes({"dry_mass": text}).get("dry_mass") if text else None
    return mass if isinstance(mass, float) else None


def planned(ledger: Ledger, flights: Sequence[Flight]) -> Flight | None:
    """The planned next flight, or else the last flown rocket with a known mass, without flights a designed or planned
    one, in today's weather; None without any of these. Raises BadValue if the saved plan cannot be read."""
    draft = ledger.draft(PLAN_DRAFT) or {}
    unflown = ledger.rockets() if not flights and not draft else []
    if not flights and not draft and not unflown:
        return None
    last = next((one for one in reversed(flights) if one.rocket and one.dry_mass is not None), ledger.latest())
    build = Flight(rocket=last.rocket, config=last.config) if last is not None else Flight()
    if unflown:
        build = Flight(rocket=unflown[0].name)
    plan = Flight() if draft.get("rocket") else build  # another rocket has its own configuration, or none
    weather = typed_weather(ledger)[0]
    return plan.with_changes(**plan_changes({**draft, **weather}))


def latest_flights(ledger: Ledger, flights: Sequence[Flight]) -> list[ListedFlight]:
    """The latest flights of a ledger, newest first, without their forecasts."""
    return [ListedFlight(id, one, None) for id, one in zip(ledger.ids(flights), flights, strict=True)][::-1]


def overview(ledger: Ledger, motors: Catalogue) -> Overview | None:
    """The launch day, None without flights and plan. Nothing is computed: everything is read from the ledger.
    Raises BadValue if the saved plan cannot be read.
    """
    flights = ledger.flights(last=MAX_LISTED_FLIGHTS)
    plan = planned(ledger, flights)
    if plan is None:
        return None
    forecasts = list_forecasts(ledger, motors)
    of_flights = by_flight(forecasts)
    waiting = waiting_plan(ledger)
    open_one = next((one for one in forecasts if waiting and one.made.number == waiting.number and one.waits), None)
    listed = [
        replace(one, forecast=of_flights.get((one.flight.rocket, one.flight.flight_id)))
        for one in latest_flights(ledger, flights)
    ]
    weather = weather_of(typed_weather(ledger)[0])
    return Overview(plan, weather, open_one, tuple(listed))


def first_forecast(ledger: Ledger, motors: Catalogue, settings: Settings, plan: Flight) -> Prediction:
    """Save the plan of a rocket that has not flown, and the forecast of its first flight.

    Raises UnknownMotor, ImpossibleFlight for a plan without a dry mass, BadValue for a file of kits or limits or a
    recovery figure that cannot be read, DamagedModel if the hyperprior cannot be read.
    """
    texts = answer_texts(plan, ("rocket", "config", "dry_mass", "diameter"))
    save_plan(ledger, texts | typed_weather(ledger)[0])
    full = completed_plan(ledger, motors, plan, settings)
    (made,) = predict_plans(ledger, motors, [full], save="plan")
    return made


def plan_changes(texts: Mapping[str, str]) -> dict[str, object]:
    """The fields of a plan from the entered answers, in the form saved in the ledger, with its further columns. Raises
    BadValue."""
    values = {name: read_answer(name, text) for name, text in texts.items() if name not in FURTHER}
    further = {name: texts[name] for name in FURTHER if texts.get(name)}
    return values | ({"extra": further} if further else {})
