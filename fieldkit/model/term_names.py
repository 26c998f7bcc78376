"""The names of terms that several modules look up."""


def fleet_term(quantity: str) -> str:
    """The name of the term for one quantity of a flyer's whole fleet."""
    return f"{quantity} of the fleet"


def drift_term(quantity: str) -> str:
    """The name of the term for the change of one quantity of a flyer's whole fleet per year."""
    return f"{quantity} of the fleet per year"


def config_term(quantity: str, config: str) -> str:
    """The name of the term for one quantity of one configuration, also if it is called like a motor type."""
    return f"{quantity} of configuration {config}"
