"""The names of terms that several modules look up."""


def fleet_term(quantity: str) -> str:
    """The name of the term for one quantity of a flyer's whole fleet."""
    return f"{quantity} of the fleet"


def drift_term(quantity: str, year: int) -> str:
    """The name of the term for the change of one quantity of a flyer's whole fleet in a year, counted from 1."""
    return f"{fleet_term(quantity)} in year {year}"


def is_drift(term: str) -> bool:
    """Whether a term is one of `drift_term`."""
    return " of the fleet in year " in term


def config_term(quantity: str, config: str) -> str:
    """The name of the term for one quantity of one configuration, also if it is called like a motor type."""
    return f"{quantity} of configuration {config}"
