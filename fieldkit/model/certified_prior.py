"""The hyperprior for motors, masses and devices that match their documents, with which the search looks for effects."""

from types import MappingProxyType

import numpy as np

from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.scale import Scale

CERTIFIED_PRIOR = Hyperprior(
    kind="certified",
    means=MappingProxyType({"drag": float(np.log(0.6))}),
    sds=MappingProxyType(
        {
            "drag.rocket": 0.35,
            "drag.config": 0.0105,
            "drag.flight": 0.03,
            "thrust.rocket": 0.007,
            "thrust.motor": 0.007,
            "thrust.flight": 0.025,
            "mass.rocket": 0.02,
            "stretch.motor": 0.014,
            "stretch.flight": 0.02,
            "delay.motor": 0.08,
            "delay.flight": 0.08,
            "tilt.flight": 1.0,
            "top_speed.rocket": 0.01,
            "burn_time.rocket": 0.05,
            "peak_accel.rocket": 0.06,
            "coast_to_apogee.rocket": 0.01,
            "apogee_to_eject.rocket": 0.1,
            "coast_drag.rocket": 0.02,
            "coast_drag.ports": 0.21,
            "burn_impulse.rocket": 0.01,
        }
    ),
    fixed=(1.5, 0.7, 0.07, 0.5, 0.08, 0.15, 0.0, 0.0),
    ratio=(0.005, 0.015, 0.02, 0.04, 0.01, 0.0, 0.05, 0.03),
    unknown_area=0.45,
    scatter=Scale((0.5, 1.0, 1.6, 2.5, 4.0, 6.5), 2.0, 0.7),
    reading=Scale((0.7, 1.2, 2.0), 1.0, 0.4),
    motors=Scale((1.4,), 1.4, 0.7, ends=(0.1, 10.0), points=4),
    scaled_by_motors=("stretch", "delay"),
)
"""Motors match their certificates (2 to 3% within a lot), Cd is 0.35 to 1.1 (Mandell et al., 1973; Hoerner, 1965),
masses are as weighed, devices meet their specifications. `motors` scales burn time and delay, which scatter 1.3 to 1.4
times as much in the learned hyperprior; each has a readout of its own, from which nothing follows for thrust. `tilt` is
the squared launch angle in (5 degrees)^2."""
