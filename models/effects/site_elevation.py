"""Site elevation: the field is higher or lower than recorded, which changes the air and the altimeter's readings."""

from fieldkit.physics.effect import Effect, Prior
from fieldkit.physics.setups import at_elevation

EFFECT = Effect(
    title="a higher or lower site",
    family="air",
    explains="a site is higher or lower than recorded, so its air is thinner or denser",
    unit="m",
    prior=Prior(mean=0.0, sd=1200.0, low=-3000.0, high=5000.0),
    source="U.S. Standard Atmosphere 1976: a tenth less density per 1,000 m (3,300 ft)",
    tell_apart="record the site's elevation",
    setup=at_elevation,
    per="site",
    everywhere=False,
    form_of="air_density",
    measured=10.0,
    says=(
        "The site lies about {amount} lower than recorded",
        "The site lies about {amount} higher than recorded",
    ),
)
