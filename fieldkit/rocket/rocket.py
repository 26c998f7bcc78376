"""`Rocket` and `Configuration`: the figures of a build that every flight of it shares."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Configuration:
    """What is known about one build of a rocket apart from its flights; None if unknown. SI.

    `dry_mass` to `cp` are those of its design, from the file `source`; `cg` and `cp` are the centers of gravity and of
    pressure as it leaves the launch rod, from the tip of the nose, with the motor of the design. `dry_cg` and
    `mount_end` are the center of gravity without a motor and the aft end of its mount, from there too. `weighed_mass`,
    without a motor, and `measured_diameter` are as the flyer stated them, and replace those of the design.
    """

    rocket: str
    config: str
    dry_mass: float | None = None
    diameter: float | None = None
    length: float | None = None
    cd: float | None = None
    source: str = ""
    cg: float | None = None
    cp: float | None = None
    dry_cg: float | None = None
    mount_end: float | None = None
    weighed_mass: float | None = None
    measured_diameter: float | None = None

    @property
    def designed(self) -> bool:
        """Whether a design of it is known."""
        figures = (self.dry_mass, self.diameter, self.length, self.cd, self.cg, self.cp)
        return bool(self.source) or any(figure is not None for figure in figures)

    @property
    def margin(self) -> float | None:
        """Static stability margin: the center of pressure behind the center of gravity, in diameters. [1]"""
        if self.cg is None or self.cp is None or not self.diameter:
            return None
        return (self.cp - self.cg) / self.diameter

    def margin_on(self, motor_mass: float, motor_length: float, dry_mass: float | None) -> float | None:
        """The static margin with a loaded motor [kg], [m], whose own center is taken at its middle, and the rocket's
        mass without it [kg]; None if the design does not show it. [1]"""
        weighed = (self.dry_mass, self.weighed_mass, dry_mass)
        mass = next((one for one in reversed(weighed) if one), None)
        if None in (self.cp, self.dry_cg, self.mount_end) or mass is None or not self.diameter:
            return None
        assert self.cp is not None
        assert self.dry_cg is not None
        assert self.mount_end is not None
        moment = mass * self.dry_cg + motor_mass * (self.mount_end - motor_length / 2)
        return (self.cp - moment / (mass + motor_mass)) / self.diameter


@dataclass(frozen=True, slots=True)
class Rocket:
    """A rocket by name, with its known configurations."""

    name: str
    configurations: tuple[Configuration, ...] = ()

    @property
    def designs(self) -> tuple[Configuration, ...]:
        """The configurations with a design."""
        return tuple(one for one in self.configurations if one.designed)

    def design(self, config: str) -> Configuration | None:
        """The design of a configuration, or the only one known; otherwise None."""
        named = [one for one in self.designs if one.config == config]
        return (named or list(self.designs))[0] if named or len(self.designs) == 1 else None

    def cds(self, configs: Iterable[str]) -> dict[str, float]:
        """Starting Cd of each of these configurations, if a design gives one. [1]"""
        designs = {config: self.design(config) for config in configs}
        return {config: design.cd for config, design in designs.items() if design and design.cd}

    def body(self, config: str) -> dict[str, float | None]:
        """Dry mass [kg] and diameter [m] of a configuration: as weighed and measured, otherwise as designed.

        What was stated without a configuration applies to all, and the only one known to a flight without one.
        """
        stated = [one for name in (config, "") for one in self.configurations if one.config == name]
        if not (config or stated) and len(self.configurations) == 1:
            stated = [*self.configurations]
        designs = [design] if (design := self.design(config)) else []
        masses = [one.weighed_mass for one in stated] + [one.dry_mass for one in designs]
        diameters = [one.measured_diameter for one in stated] + [one.diameter for one in designs]
        return {
            "dry_mass": next((one for one in masses if one is not None), None),
            "diameter": next((one for one in diameters if one is not None), None),
        }
