"""The serial ports of this computer, and the devices identified by their vendor and product numbers.

Few loggers have numbers of their own; most are behind a USB serial chip whose numbers identify only the chip's maker.
Only numbers that a maker assigned to a single device select a protocol; otherwise the user or the received bytes do.

Sources: AltosUSB product list (Altus Metrum), the USB ID repository (usb.ids) for the chips.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from fieldkit.capture.protocol import known_devices

ALTUS_METRUM = 0xFFFE
"""The vendor number that Altus Metrum uses."""
ALTOS_PRODUCTS: Mapping[int, str] = {
    0x0B: "TeleMetrum",
    0x0C: "TeleDongle",
    0x23: "TeleMega",
    0x25: "TeleGPS",
    0x26: "EasyMini",
    0x27: "TeleMini",
    0x28: "EasyMega",
    0x2B: "MicroPeak USB adapter",
    0x2C: "EasyMotor",
}
"""Product numbers of Altus Metrum; all from 0x0a to 0x2c belong to them."""
CHIPS: Mapping[int, str] = {
    0x0403: "FTDI chip",
    0x0483: "STMicroelectronics chip (used by the Blue Raven)",
    0x067B: "Prolific chip",
    0x10C4: "Silicon Labs chip",
    0x1A86: "WCH chip",
    0x2341: "Arduino board",
    0x303A: "Espressif chip",
}
"""Makers of USB serial chips, by vendor number."""
MICROPEAK_ADAPTER = (0x0403, 0x6015)
"""Vendor and product number of the MicroPeak USB adapter, which are those of its FTDI chip."""


@dataclass(frozen=True, slots=True)
class Port:
    """A serial port: its name, its USB numbers if it has any, and the device they identify."""

    name: str
    vendor: int | None = None
    product: int | None = None
    serial: str = ""
    described: str = ""
    """The system's description."""

    @property
    def about(self) -> str:
        """The device, in a few words."""
        if self.vendor == ALTUS_METRUM:
            return ALTOS_PRODUCTS.get(self.product or 0, "Altus Metrum device")
        if (self.vendor, self.product) == MICROPEAK_ADAPTER:
            return "FTDI chip (used by the MicroPeak adapter and others)"
        return CHIPS.get(self.vendor or 0, "")

    @property
    def device(self) -> str:
        """The protocol that the numbers identify, empty if they do not."""
        named = (name for name, protocol in known_devices().items() if (self.vendor, self.product) in protocol.usb)
        return next(named, "")

    def same_unit(self, other: "Port") -> bool:
        """Whether another port can be this unit, plugged in elsewhere: same USB numbers, same serial number."""
        mine = (self.vendor, self.product, self.serial)
        return self.vendor is not None and mine == (other.vendor, other.product, other.serial)


def ports() -> list[Port]:
    """The serial ports of this computer, those of known loggers first."""
    from serial.tools import list_ports  # takes 3 ms to import, and the help does not need it

    found = [
        Port(one.device, one.vid, one.pid, one.serial_number or "", one.description if one.description != "n/a" else "")
        for one in list_ports.comports()
    ]
    return sorted(found, key=lambda port: (not port.device, not port.about, port.name))


def again(unit: Port, here: Iterable[Port]) -> str | None:
    """The port on which a unit has returned, by its USB numbers or, if it has none, by its port name; None if it has
    not, or if several ports may be it.

    A port that the system does not list, such as a pseudo-terminal, is present if its path exists.
    """
    here = list(here)
    same = [port.name for port in here if unit.same_unit(port)]
    named = unit.vendor is None and (unit.name in [port.name for port in here] or Path(unit.name).exists())
    if unit.name in same or named:
        return unit.name
    return same[0] if len(same) == 1 else None
