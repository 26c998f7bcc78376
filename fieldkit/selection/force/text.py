"""The evidence of logs of the climb, in one or two sentences."""

from collections.abc import Iterator

from fieldkit.quantities import counted, with_sd
from fieldkit.selection.force.log_evidence import LogEvidence
from fieldkit.selection.force.one_flight import FoundTerm
from fieldkit.selection.force.several_flights import MIN_CLIMBS, Common

COMPARISON_TEXTS = {
    "agrees": "this supports {effects}, as does the verdict from the readouts",
    "more": "this supports {effects}, which the readouts alone do not show",
    "another effect": "this supports {effects}, which differs from the verdict from the readouts",
    "cannot tell": "the logs cannot distinguish this from the effect of the verdict",
    "nothing of it": "the effect of the verdict does not show in the logs",
}


def climbs_in_words(evidence: LogEvidence) -> Iterator[str]:
    """The missing force and its comparison with the verdict; empty if no flight has a log."""
    if evidence.flights:
        yield f"missing force, {counted(len(evidence.flights), 'log')}: {_law(evidence)}"
        if evidence.comparison:
            yield COMPARISON_TEXTS[evidence.comparison].format(effects="+".join(evidence.effects))
    reasons: dict[str, list[str]] = {}
    for flight_id, why in evidence.silent:
        reasons.setdefault(why, []).append(flight_id)
    for why, ids in reasons.items():
        others = f" and {len(ids) - 1} more" if len(ids) > 1 else ""
        yield f"{counted(len(ids), 'log')} without a missing force, {ids[0]}{others}: {why}"


def _law(evidence: LogEvidence) -> str:
    if len(evidence.flights) < MIN_CLIMBS:
        alone = ", ".join(map(_term, evidence.flights[0].law.terms)) or "none"
        return f"{alone}; one flight alone is not enough"
    terms = [f"{_term(one)} (in {one.flights} of {one.seen})" for one in evidence.law]
    return ", ".join(terms) or "nothing that recurs across flights"


def _term(one: FoundTerm | Common) -> str:
    also = f", or {', '.join(one.also)}," if one.also else ""
    return f"{one.term.name}{also} {with_sd(one.value, one.sd)} {one.term.unit}"
