"""Short phrases that report to the flyer what a log does not show, or why its appearance is misleading."""

from math import cos, degrees

EITHER_WAY = "errors go either way, within the ± that `fieldkit inspect` shows"
"""How a measurement errs for which a sensor is missing."""
DOUBT = "theirs is used, off either way by a ± that has grown by half of the difference"
"""How the samples' value errs that differs from the device's own."""

NO_HEIGHT = "the log has no height or pressure to measure with"
NO_FLIGHT = "no rocket flight in this log: nothing is measured"
NO_APOGEE = "no apogee: the log ends before it"
AFTER_END_NOTE = "the log ends just before apogee, which is between {}, as recorded, and {}, without drag"
UNSEEN_TOP_NOTE = "the apogee is in a gap of {:.0f} s: between {}, as recorded, and {}, after a coast without drag"
LOST_IN_BOOST = "a gap of {:.0f} s begins in the boost and ends after apogee: no apogee, top speed or burn time"
OTHER_FLIGHT = (
    "another flight follows {:.0f} s after the start of the log: it is not measured; save it as a log of its own"
)
EARLIER_FLIGHT = (
    "another flight ends about {:.0f} s after the start of the log: it is not measured; save it as a log of its own"
)
NO_LIFTOFF = "the log begins after lift-off: no burn time, no times from lift-off"
NO_BOOST = "the boost is missing or distorted: no top speed, burn time or acceleration"
DIVES_NOTE = "the pressure in the airframe hides the boost: no burn time or acceleration"
STEP_NOTE = "the heights jump by {} in the boost, faster than any rocket: no top speed, burn time or acceleration"
NO_PAD = "the log begins in flight and its heights are not above the pad: no apogee"
CLIPPED_NOTE = f"the accelerometer was saturated in the boost: only heights are used for it; {EITHER_WAY}"
FILLED_NOTE = (
    "the accelerometer was saturated for {:.1f} s of the boost: "
    f"the missing {{:.1f}} g on average are filled in from the heights; {EITHER_WAY}"
)
ENDS_IN_BOOST = f"the accelerometer's samples end in the boost: it is measured from heights only; {EITHER_WAY}"
ONLY_CLOCK_NOTE = f"the acceleration {{}}: only its clock is used, for lift-off and burnout; {EITHER_WAY}"
OTHER_SENSOR_NOTE = (
    f"another acceleration of the log does not agree with the heights: the {{}} is used instead; {EITHER_WAY}"
)
REJECTED_NOTE = f"the acceleration {{}}: it is not used; the boost is measured from heights only; {EITHER_WAY}"
UNCHECKED_NOTE = (
    "shows no gravity on the way down, so it was computed, and the log shows too little of the pad to check it"
)
SLANTED_NOTE = (
    "it climbed about {:.0f} degrees from vertical, the angle at which accelerometer and heights agree: upright "
    "it would have gone up to {:.0%} higher"
)
ENERGY_NOTE = "the climb after burnout needs at least {}: the top speed is the measured one, bounded by that"
FILTERED_NOTE = "the heights are behind a filter of about {:.1f} s: events after the boost are late by about that"
SMOOTH_NOTE = (
    "the heights lack the noise of a sensor, so they are behind a filter of unknown delay: events may be up to about a "
    "second late, and no peak acceleration is seen"
)
NO_LANDING = "the log ends before landing: no duration"


def slanted_note(angle: float) -> str:
    """The note on a climb at an angle from vertical [rad]. The height of a coast without drag is in proportion to the
    square of its cosine, that of a boost to the cosine; drag makes the loss smaller."""
    return SLANTED_NOTE.format(degrees(angle), 1 / cos(angle) ** 2 - 1)
