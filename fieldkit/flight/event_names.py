"""Events of a flight as they are displayed."""


def event_title(name: str) -> str:
    """The name of an event for display: `lift-off` for `liftoff`, which is its name in JSON."""
    return "lift-off" if name == "liftoff" else name.replace("_", " ")
