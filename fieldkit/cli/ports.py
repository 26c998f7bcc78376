"""`fieldkit capture --list`: the serial ports of this computer, and the supported devices."""

from typing import TYPE_CHECKING

from fieldkit.cli.screen import complain, print_json, print_table, say

if TYPE_CHECKING:
    from fieldkit.capture import Port


def print_ports(json: bool) -> None:
    """Print ports, supported devices, and devices that only their vendor's program can read."""
    from fieldkit.capture import known_devices, ports
    from fieldkit.capture.protocol import NOT_PUBLIC

    here = ports()
    if json:
        print_json(
            {
                "ports": [
                    {
                        "port": port.name,
                        "vendor": port.vendor,
                        "product": port.product,
                        "serial": port.serial,
                        "described": port.described,
                        "about": port.about,
                        "device": port.device or None,
                    }
                    for port in here
                ],
                "devices": {name: one.title for name, one in known_devices().items()},
                "not_public": dict(NOT_PUBLIC),
            }
        )
        return
    rows = [(port.name, _numbers(port), port.about or port.described, port.device) for port in here]
    if rows:
        print_table(("port", "numbers", "identified as", "device"), rows)
    else:
        say("No serial ports found; plug in the logger or its adapter")
    say()
    print_table(("device", "description"), [(name, one.title) for name, one in known_devices().items()])
    for name, text in NOT_PUBLIC.items():
        complain(f"{name}: {text}")


def _numbers(port: "Port") -> str:
    return "" if port.vendor is None else f"{port.vendor:04x}:{port.product or 0:04x}"
