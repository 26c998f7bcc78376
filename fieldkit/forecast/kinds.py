"""Kinds of plans: plans that one model can forecast together without affecting each other."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.physics.effect import effects
from fieldkit.physics.history import GROUP_LEVELS, groups

T = TypeVar("T")


def by_kind(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]],
    work: Callable[[Sequence[int]], Sequence[T]],
) -> list[T]:
    """Apply a function to the plans, all plans of a kind at once, given their rows; results in the order of the plans.

    Plans of one kind add the same new terms to the model. With plans of another kind the model would have terms that do
    not concern them, which would change their forecasts.
    """
    kinds: dict[tuple[object, ...], list[int]] = {}
    for row, news in enumerate(_news(flown, [flight for flight, _ in planned], [found for _, found in planned])):
        kinds.setdefault(news, []).append(row)
    made = {row: one for rows in kinds.values() for row, one in zip(rows, work(rows), strict=True)}
    return [made[row] for row in range(len(planned))]


def _news(
    flown: Sequence[tuple[Flight, Found]], plans: Sequence[Flight], found: Sequence[Found]
) -> Iterator[tuple[object, ...]]:
    """The properties of each plan that decide the model's terms: whether its motor, configuration, site and day are
    new, whether it has a date and a diameter, and the conditions that effects need or replace. New configurations are
    distinguished, because each may have its own design."""
    past = [flight for flight, _ in flown]
    known = {per: set(groups(past, [one for _, one in flown], per)) for per in GROUP_LEVELS}
    ours = {per: groups(plans, found, per) for per in GROUP_LEVELS}
    columns = {name for effect in effects().values() for name in (effect.needs, effect.lacks) if name}
    for row, plan in enumerate(plans):
        old = [bool(flown) and ours[per][row] in known[per] for per in GROUP_LEVELS]
        given = [(plan.number(name) is None, bool(plan.number(name))) for name in ("diameter", *sorted(columns))]
        own_design = None if flown and plan.config in known["config"] else plan.config
        yield (*old, *given, plan.date_time is None, own_design)
