"""A motor in the words of a flyer, and its thrust curve as a plot."""

from typing import Any

import numpy as np

from fieldkit.motors import Motor
from fieldkit.motors.motor import delays_text
from fieldkit.quantities import written
from fieldkit.safe_text import printable
from fieldkit.tui.widgets.plots import AXIS, below_line

KINDS = {"SU": "single use", "reload": "reloadable", "hybrid": "hybrid"}
"""Kinds of motors in the catalog, in the words of a flyer."""


def facts(motor: Motor, system: str) -> tuple[tuple[str, str], ...]:
    """The catalog data of a motor, name and value with its unit; masses in the units of a system."""

    def mass(value: float) -> str:
        return written(value, "g", system, 1 if system == "SI" else None)

    delays = delays_text(motor.delays)
    pairs = (
        ("maker", motor.maker),
        ("designation", motor.designation),
        (
            "kind",
            ", ".join(part for part in (KINDS.get(motor.kind, motor.kind), f"class {motor.impulse_class}") if part),
        ),
        ("diameter", f"{motor.diameter * 1e3:g} mm"),
        ("length", f"{motor.length * 1e3:g} mm"),
        ("total impulse", f"{motor.total_impulse:.1f} N s"),
        ("average thrust", f"{motor.rated_thrust:.1f} N"),
        ("peak thrust", f"{motor.peak_thrust:.1f} N"),
        ("burn time", f"{motor.rated_burn:.2f} s{'' if motor.certified_burn else ' above 5% of the peak'}"),
        ("loaded mass", mass(motor.loaded_mass)),
        ("propellant", " ".join((mass(motor.propellant_mass), motor.propellant)).strip()),
        ("empty mass", mass(motor.casing_mass)),
        ("delays", "none listed" if delays == "-" else f"{delays} s{'; P: plugged, no charge' * ('P' in delays)}"),
        ("on sale", "yes" if motor.available else "no longer made"),
        ("case", motor.case),
        ("estimated", ", ".join(name.replace("_", " ") for name in motor.estimated)),
        ("thrust curve", motor.curve),
        ("corrected", "; ".join(one.text() for one in motor.corrections if one.applied)),
        ("web page", motor.url),
        ("source", motor.source),
    )
    return tuple((name, printable(value)) for name, value in pairs if value)


THRUST = "thrust [N] against time [s], ╌ its average"
"""The title of a thrust curve."""


def draw_thrust(motor: Motor, plt: Any, ink: Any) -> None:
    """Draw thrust against time, and the average while it burns."""
    columns = np.linspace(0.0, motor.thrust_end, max(2, ink.width - AXIS))
    filled = below_line(np.interp(columns, motor.time, motor.thrust), motor.peak_thrust, ink)
    plt.plot(columns.tolist(), filled.tolist(), marker="░", color=ink.line, fillx=True)
    plt.plot(motor.time.tolist(), motor.thrust.tolist(), marker="braille", color=ink.line)
    start, end = motor.burning
    plt.plot([start, end], [motor.rated_thrust] * 2, marker="╌", color=ink.mark)
    last = motor.thrust_end
    plt.xlim(0, last)
    plt.ylim(0, motor.peak_thrust * 1.05)
    plt.xticks([0, last / 2, last], ["0", f"{last / 2:.2g}", f"{last:.2g} s"])
    plt.yticks(
        [0, motor.rated_thrust, motor.peak_thrust], ["0", f"{motor.rated_thrust:.3g}", f"{motor.peak_thrust:.3g}"]
    )
