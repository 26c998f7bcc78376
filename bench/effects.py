"""The true effects: each modifies the launches of a season and returns its true parameters.

`bend(rng, strength, flights)` returns the modified flights and the true parameters. It changes the recorded values
(`declared`) only if the effect is about them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from bench.fleet import Flown
from bench.world import Drag, Launch

Parameters = dict[str, float | str]
Bend = Callable[[np.random.Generator, float, Sequence[Flown]], tuple[list[Flown], Parameters]]


def _each(flights: Sequence[Flown], change: Callable[[Launch], Launch], where: Callable[[Flown], bool]) -> list[Flown]:
    return [replace(f, launch=change(f.launch)) if where(f) else f for f in flights]


def _declare(flown: Flown, **columns: str | float) -> Flown:
    return replace(flown, declared=dict(flown.declared) | columns)


def _undeclare(flown: Flown, *columns: str) -> Flown:
    return replace(flown, declared={k: v for k, v in flown.declared.items() if k not in columns})


def _one(rng: np.random.Generator, names: Sequence[str]) -> str:
    return str(rng.choice(sorted(set(names))))


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _middle(rng: np.random.Generator, flights: Sequence[Flown]) -> Flown:
    """A flight around the middle of the history, the first of its day."""
    about = flights[int(len(flights) * rng.uniform(0.25, 0.45))]
    return next(f for f in flights if f.when.date() == about.when.date())


def none(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """No effect: the declared conditions are true."""
    return list(flights), {}


def realistic(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """The small departures from a constant drag coefficient that every rocket has."""

    def change(launch: Launch) -> Launch:
        return replace(launch, drag=Drag(launch.drag.cd, 1.05, 0.6, 0.06))

    return _each(flights, change, lambda f: True), {"power_off": 1.05, "reynolds": 0.06, "mach_rise": 0.6}


def wind(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Days from calm to 9 m/s, declared; `strength` is the static margin, set when the rocket was drawn."""
    days = sorted({f.when.date() for f in flights})
    mean = dict(zip(days, rng.permutation(np.linspace(0.3, 8.0, len(days))), strict=True))
    bent = []
    for flown in flights:
        blow = float(np.clip(mean[flown.when.date()] * rng.uniform(0.8, 1.2), 0, 9))
        launch = replace(flown.launch, air=replace(flown.launch.air, wind=blow))
        bent.append(_declare(replace(flown, launch=launch), wind_mps=round(blow * 2) / 2))
    return bent, {"static_margin_cal": strength, "rail_length_m": flights[0].launch.rail_length}


def launch_angle(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """A rail tilted by `strength` degrees on every flight or at one site, not recorded."""
    sites = sorted({f.site for f in flights})
    site = _one(rng, sites) if len(sites) > 1 and rng.random() < 0.5 else "all"
    tilt, heading = float(np.radians(strength)), float(rng.uniform(0, 2 * np.pi))

    def change(launch: Launch) -> Launch:
        return replace(launch, tilt=tilt, heading=heading)

    bent = _each(flights, change, lambda f: site in ("all", f.site))
    return [_undeclare(f, "rail_angle_deg") for f in bent], {"angle_deg": strength, "site": site}


def early_ejection(
    rng: np.random.Generator, strength: float, flights: Sequence[Flown]
) -> tuple[list[Flown], Parameters]:
    """Delays so short that the charge fires about `strength` seconds before apogee, on one motor or all."""
    motor = _one(rng, [f.motor for f in flights]) if rng.random() < 0.6 else "all"
    hit = [f for f in flights if motor in ("all", f.motor)]
    short = float(np.mean([f.launch.delay - f.coast for f in hit])) + strength

    def change(launch: Launch) -> Launch:
        return replace(launch, delay=max(launch.delay - short, 0.5))

    return _each(flights, change, lambda f: motor in ("all", f.motor)), {"delay_short_s": short, "motor": motor}


def air_density(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """One site is at `strength` meters, and its elevation is not recorded or wrong."""
    site = _one(rng, [f.site for f in flights])
    wrong = bool(rng.random() < 0.3)
    bent = []
    for flown in flights:
        if flown.site != site:
            bent.append(flown)
            continue
        air = flown.launch.air
        kelvin = air.temperature - 0.0065 * (strength - air.elevation)
        launch = replace(flown.launch, air=replace(air, elevation=strength, temperature=kelvin))
        changed = replace(flown, launch=launch)
        if "temperature_c" in changed.declared:
            changed = _declare(changed, temperature_c=round(kelvin - 273.15))
        bent.append(_declare(changed, site_elevation_m=0) if wrong else _undeclare(changed, "site_elevation_m"))
    return bent, {"elevation_m": strength, "site": site, "declared": "0 m" if wrong else "nothing"}


def hot_days(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Days from cold to `strength` K above the standard, and no temperature in the table."""
    days = sorted({f.when.date() for f in flights})
    extra = dict(zip(days, rng.permutation(np.linspace(-strength / 2, strength, len(days))), strict=True))
    bent = []
    for flown in flights:
        kelvin = 288.15 - 0.0065 * flown.launch.air.elevation + float(extra[flown.when.date()])
        launch = replace(flown.launch, air=replace(flown.launch.air, temperature=kelvin))
        bent.append(_undeclare(replace(flown, launch=launch), "temperature_c"))
    return bent, {"hottest_over_standard_k": strength}


def mass_offset(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """One configuration weighs more or less than recorded, by the fraction `strength`."""
    config, part = _one(rng, [f.config for f in flights]), _sign(rng) * strength

    def change(launch: Launch) -> Launch:
        return replace(launch, dry_mass=launch.dry_mass * (1 + part))

    return _each(flights, change, lambda f: f.config == config), {"offset": part, "config": config}


def motor_thrust(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """One motor type, or a later lot of it, has more or less impulse, by the fraction `strength`."""
    motor, part = _one(rng, [f.motor for f in flights]), _sign(rng) * strength
    start = _middle(rng, flights).when if rng.random() < 0.3 else flights[0].when

    def hit(flown: Flown) -> bool:
        return flown.motor == motor and flown.when >= start

    def change(launch: Launch) -> Launch:
        return replace(launch, motor=replace(launch.motor, thrust=launch.motor.thrust * (1 + part)))

    bent = _each(flights, change, hit)
    if start != flights[0].when:
        bent = [_declare(f, motor_lot="2" if hit(f) else "1") for f in bent]
    return bent, {"impulse": part, "motor": motor, "from": start.date().isoformat()}


def thrust_curve(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """The burn is longer by the fraction `strength` at the same impulse, on one motor or all."""
    motor = _one(rng, [f.motor for f in flights]) if rng.random() < 0.5 else "all"

    def change(launch: Launch) -> Launch:
        curve = launch.motor
        longer = replace(curve, time=curve.time * (1 + strength), thrust=curve.thrust / (1 + strength))
        return replace(launch, motor=longer)

    return _each(flights, change, lambda f: motor in ("all", f.motor)), {"stretch": 1 + strength, "motor": motor}


def mach_drag(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Drag rises toward Mach 1, by the fraction `strength` at its maximum."""
    bent = _each(flights, lambda x: replace(x, drag=replace(x.drag, mach_rise=strength)), lambda f: True)
    return bent, {"rise": strength}


def base_drag(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Drag is higher by the fraction `strength` after burnout."""
    bent = _each(flights, lambda x: replace(x, drag=replace(x.drag, power_off=1 + strength)), lambda f: True)
    return bent, {"after_burnout": strength}


def altimeter_scale(
    rng: np.random.Generator, strength: float, flights: Sequence[Flown]
) -> tuple[list[Flown], Parameters]:
    """The barometer reads heights too high or too low by the fraction `strength`, always or from some day on."""
    gain = 1 + _sign(rng) * strength
    start = _middle(rng, flights).when if rng.random() < 0.25 else flights[0].when
    bent = [replace(f, gain=gain) if f.when >= start else f for f in flights]
    return bent, {"gain": gain, "from": start.date().isoformat()}


def wear(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Drag grows with every flight by the fraction `strength` of the first flight's drag."""
    bent = [
        replace(f, launch=replace(f.launch, drag=replace(f.launch.drag, cd=f.launch.drag.cd * (1 + strength * i))))
        for i, f in enumerate(flights)
    ]
    return bent, {"drag_per_flight": strength}


def rail_friction(
    rng: np.random.Generator, strength: float, flights: Sequence[Flown]
) -> tuple[list[Flown], Parameters]:
    """Friction on the rail is `strength` times the rocket's weight."""

    def change(launch: Launch) -> Launch:
        return replace(launch, friction=strength * 9.80665 * (launch.dry_mass + launch.motor.total_mass))

    return _each(flights, change, lambda f: True), {"friction_in_weights": strength}


def hour_bias(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Thermals: the air rises at up to `strength` m/s in mid-afternoon and not at all in the morning."""

    def change(flown: Flown) -> Flown:
        hour = flown.when.hour + flown.when.minute / 60
        rise = strength * float(np.clip((hour - 11) / 3, 0, 1))
        return replace(flown, launch=replace(flown.launch, air=replace(flown.launch.air, updraft=rise)))

    return [change(f) for f in flights], {"updraft_mps": strength}


def bad_day(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """Rain on the rocket on one day: drag is higher by the fraction `strength`."""
    day = _middle(rng, flights).when.date()

    def change(launch: Launch) -> Launch:
        return replace(launch, drag=replace(launch.drag, cd=launch.drag.cd * (1 + strength)))

    return _each(flights, change, lambda f: f.when.date() == day), {"drag": strength, "day": day.isoformat()}


def drag_step(rng: np.random.Generator, strength: float, flights: Sequence[Flown]) -> tuple[list[Flown], Parameters]:
    """After a repair, drag stays higher by the fraction `strength`."""
    start = _middle(rng, flights).when

    def change(launch: Launch) -> Launch:
        return replace(launch, drag=replace(launch.drag, cd=launch.drag.cd * (1 + strength)))

    return _each(flights, change, lambda f: f.when >= start), {"drag": strength, "from": start.date().isoformat()}


def third_payload(
    rng: np.random.Generator, strength: float, flights: Sequence[Flown]
) -> tuple[list[Flown], Parameters]:
    """Every third flight carries a payload that nobody weighed, the fraction `strength` of the dry mass."""
    bent = [
        replace(f, launch=replace(f.launch, dry_mass=f.launch.dry_mass * (1 + strength))) if i % 3 == 2 else f
        for i, f in enumerate(flights)
    ]
    return bent, {"payload": strength}


EFFECTS: Mapping[str, Bend] = {
    effect.__name__: effect
    for effect in (
        none, realistic, wind, launch_angle, early_ejection, air_density, hot_days, mass_offset, motor_thrust,
        thrust_curve, mach_drag, base_drag, altimeter_scale, wear, rail_friction, hour_bias, bad_day, drag_step,
        third_payload,
    )
}  # fmt: skip
"""Every effect by its name."""
