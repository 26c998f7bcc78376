"""Heavier recovery: from some flight on, the rocket carries a larger parachute, a longer cord or a tracker that was not
weighed."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def setup(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    """Increases the dry mass by this fraction."""
    return setup.with_changes(dry_mass=setup.dry_mass * (1 + strength))


EFFECT = Effect(
    title="heavier recovery gear",
    family="mass",
    explains="from some flight on the rocket carries more than the mass entered, such as a larger parachute",
    unit="fraction of the dry mass",
    prior=Prior(mean=0.06, sd=0.05, low=0.0, high=0.5),
    source="a judgment: recovery gear weighs 5 to 15% of a model rocket, and is replaced most often",
    tell_apart="weigh the rocket again, ready to fly but without the motor",
    setup=setup,
    form_of="mass_offset",
    starts_anywhere=True,
    from_first=False,
    measured=0.005,
    says=(
        "{where} carries about {amount} less than entered",
        "{where} carries about {amount} more than entered",
    ),
)
