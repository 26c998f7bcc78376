"""The checklist at the pad for the planned flight that waits."""

from dataclasses import dataclass

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.paths import data_file
from fieldkit.planning.descent_rate import fall_of
from fieldkit.planning.limits import limits
from fieldkit.planning.pad import general_checklist, pad_checklist
from fieldkit.planning.safety import safety_lines
from fieldkit.services.forecasts import predict_plans, rocket_of
from fieldkit.services.launch_day import plan_changes
from fieldkit.services.manual_entry import PLAN, waiting_plan
from fieldkit.services.plans import completed_plan
from fieldkit.services.sites import site_of
from fieldkit.settings import Settings


@dataclass(frozen=True, slots=True)
class Checklist:
    """The steps at the pad, with marked amounts, for a flight that `title` names."""

    title: str
    steps: tuple[str, ...]


def waiting_checklist(ledger: Ledger, motors: Catalogue, settings: Settings) -> Checklist:
    """The checklist of the flight whose forecast was saved last and that has not flown, with its safety checks; without
    one, that of any flight. Raises FieldkitError if the plan cannot be forecast any more."""
    waiting = waiting_plan(ledger)
    if waiting is None:
        return Checklist("any flight", tuple(general_checklist()))
    plan = completed_plan(ledger, motors, Flight().with_changes(**plan_changes(waiting.payload[PLAN])), settings)
    (made,) = predict_plans(ledger, motors, [plan], save="nothing")
    fall = fall_of(rocket_of(ledger, motors, plan.rocket).history, made.plan, made.found)
    lines = safety_lines(made, site_of(ledger, made.plan.site), fall, limits(data_file("limits.toml")))
    named = " ".join(filter(None, (plan.rocket, plan.config, "on", plan.motor)))
    return Checklist(named, tuple(pad_checklist(made.plan, made.found, lines)))
