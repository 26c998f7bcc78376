"""The motors of the bench: measured thrust curves from the catalog, at their certified impulse."""

from functools import cache

from bench.world import Motor
from fieldkit.motors import catalogue

NAMES = (
    "Estes C6", "Estes C11", "D13W", "D24T", "Estes D12", "D15T", "Estes E12", "E20W", "E28T", "E35W", "F24W", "F39T",
    "F35W", "F27R", "F26FJ", "F37W", "F40W", "F52T", "F67W", "G38FJ", "AeroTech G40W", "G54W", "G64W", "AeroTech G80T",
    "G125T", "H128W", "H165R", "AeroTech H100W", "H182R", "H135W",
)  # fmt: skip
"""Names as flyers write them, with the manufacturer if several use a name."""


@cache
def motors() -> dict[str, Motor]:
    """Every motor of the bench by its name without the manufacturer: letter, number and propellant, `F24W`, `D12`."""
    return {text.split()[-1]: motor(text) for text in NAMES}


def motor(text: str) -> Motor:
    found = catalogue().find(text).motor
    name = text.split()[-1].rstrip("WTRFJ")
    return Motor(
        name=name,
        maker=text.split()[0] if " " in text else "",
        suffix=text.split()[-1].removeprefix(name),
        diameter=found.diameter,
        length=found.length,
        total_mass=found.loaded_mass,
        propellant_mass=found.propellant_mass,
        delays=tuple(int(delay) for delay in found.delays if 0 < delay < 30),
        time=found.time,
        thrust=found.thrust,
    )
