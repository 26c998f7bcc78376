"""Shared by Altus Metrum flight computers and radios: a command line with an echo, and the version query.

Source: AltosLink.java (Altus Metrum).
"""

import time

from fieldkit.capture.link import NOISE, Dialogue, Link

ANSWER = 5.0
"""Timeout for a line from a unit. [s]"""
NAMES = {"product": "model", "serial-number": "serial", "software-version": "firmware"}
"""Keys of the answer to `v` that are recorded in `Link.about`, with their names there."""


def silence_echo(link: Link) -> Dialogue[None]:
    """Clear earlier input, and turn off the echo."""
    link.send(b"~\n")
    link.send(b"E 0\n")
    yield from link.drain(0.3)


def version(link: Link) -> Dialogue[dict[str, str]]:
    """The answer to `v`, key to value; empty if it is incomplete. Also records what `NAMES` lists in `link.about`."""
    found: dict[str, str] = {}
    link.send(b"v\n")
    ends = time.monotonic() + NOISE * ANSWER
    while time.monotonic() < ends and (line := (yield from link.text_line(ANSWER))) is not None:
        key, _, value = line.strip().partition(" ")
        found[key] = value.strip().strip('"')
        if key == "software-version":
            link.about.update({NAMES[key]: value for key, value in found.items() if key in NAMES})
            return found
    return {}
