"""Kinds of plans: those that a model of a rocket's flights can take in together without one changing another."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from fieldkit.flight import Flight
from fieldkit.model.rocket_model import GROUP_LEVELS, groups
from fieldkit.motors import Found
from fieldkit.physics.effect import effects

T = TypeVar("T")


def by_kind(
    flown: Sequence[tuple[Flight, Found]],
    planned: Sequence[tuple[Flight, Found]],
    work: Callable[[Sequence[int]], Sequence[T]],
) -> list[T]:
    """What some work makes of plans, given their rows, in the order of the plans: those of a kind at once.

    Of one kind are plans that bring the same news to what has flown. With others a model would hold terms that they
    have no part in, and each would be less certain, or luckier, for the company it keeps.
    """
    kinds: dict[tuple[object, ...], list[int]] = {}
    for row, news in enumerate(_news(flown, [flight for flight, _ in planned], [found for _, found in planned])):
        kinds.setdefault(news, []).append(row)
    made = {row: one for rows in kinds.values() for row, one in zip(rows, work(rows), strict=True)}
    return [made[row] for row in range(len(planned))]


def _news(
    flown: Sequence[tuple[Flight, Found]], plans: Sequence[Flight], found: Sequence[Found]
) -> Iterator[tuple[object, ...]]:
    """What each plan brings that terms of a model hang on: a motor, a configuration, a site or a day that is new or
    not, a diameter, the conditions that effects need or stand in for. Of a rocket never flown builds are distinguished,
    for each may have a design of its own."""
    past = [flight for flight, _ in flown]
    known = {per: set(groups(past, [one for _, one in flown], per)) for per in GROUP_LEVELS}
    ours = {per: groups(plans, found, per) for per in GROUP_LEVELS}
    columns = {name for effect in effects().values() for name in (effect.needs, effect.lacks) if name}
    for row, plan in enumerate(plans):
        new = [bool(flown) and ours[per][row] in known[per] for per in GROUP_LEVELS]
        given = [(plan.number(name) is None, bool(plan.number(name))) for name in ("diameter", *sorted(columns))]
        yield (*new, *given, None if flown else plan.config)
