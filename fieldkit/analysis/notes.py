"""What a log does not show, or shows otherwise than it seems, in a phrase for the flyer."""

NO_HEIGHT = "the log has no height or pressure to measure with"
NO_FLIGHT = "nothing in this log rises as a rocket does: no figure is taken from it"
NO_APOGEE = "no apogee in this log: it ends before the top"
UNSEEN_TOP_NOTE = (
    "the top is in a gap of {:.0f} s: it lies between {:.0f} m, which was recorded, and {:.0f} m, a coast without drag"
)
NO_LIFTOFF = "the log begins after lift-off: no burn time, no times from lift-off"
NO_BOOST = "the boost is not in the log, or not as it was: no top speed, no burn time, no acceleration"
NO_PAD = "the log begins in flight and its heights do not count from the pad: no height above it"
CLIPPED_NOTE = "the accelerometer was saturated in the boost: only heights are used for it"
FILLED_NOTE = (
    "the accelerometer was saturated for {:.1f} s of the boost: "
    "the {:.0f} m/s² that it missed on average are filled in from the heights"
)
DISBELIEVED = "the acceleration {}: it is not used as acceleration along the axis, only heights are used for the boost"
LEANED = "it climbed at about {:.0f} degrees from the vertical: with that, its accelerometer and its heights agree"
NO_LANDING = "the log ends before landing: no duration"
