"""From the bytes of an `.ork` file to its XML: a zip with `rocket.ork` in it, a gzip, or plain XML.

Nothing is unpacked past `MOST`, and defusedxml refuses document types and entities, which swell or reach elsewhere.
"""

import io
import zipfile
import zlib
from typing import TYPE_CHECKING

from fieldkit.errors import DamagedLog

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MOST = 64 * 2**20
"""Bytes that a file may unpack to; a design with many stored simulations has a few millions. [byte]"""


def root_of(content: bytes, source: str) -> "Element":
    """The root element of a design. Raises DamagedLog that names the file, and the row where XML breaks."""
    from xml.etree.ElementTree import ParseError

    from defusedxml.common import DefusedXmlException
    from defusedxml.ElementTree import fromstring

    try:
        root: Element = fromstring(_unpacked(content, source), forbid_dtd=True)
    except ParseError as error:
        row, _ = error.position
        raise DamagedLog(f"found broken XML ({str(error).split(':')[0]})", row=row, source=source) from error
    except DefusedXmlException as error:
        found = "found a document type or entities, expected plain XML without <!DOCTYPE>"
        raise DamagedLog(found, source=source) from error
    except (LookupError, ValueError) as error:
        raise DamagedLog(f"found an encoding that cannot be read ({error})", source=source) from error
    if root.tag != "openrocket" or root.find("rocket") is None:
        found = f"found <{root.tag[:40]}>, expected <openrocket> with a <rocket> in it"
        raise DamagedLog(found, source=source)
    return root


def _unpacked(content: bytes, source: str) -> bytes:
    if content.startswith(b"PK"):
        return _from_zip(content, source)
    if content.startswith(b"\x1f\x8b"):
        return _from_gzip(content, source)
    if len(content) > MOST:
        raise _too_long(source)
    return content


def _from_zip(content: bytes, source: str) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".ork")]
            if not names:
                raise DamagedLog("found a zip without rocket.ork in it, expected an OpenRocket design", source=source)
            with archive.open("rocket.ork" if "rocket.ork" in names else names[0]) as file:
                unpacked = file.read(MOST + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as error:
        raise DamagedLog(f"found a zip that cannot be unpacked ({error})", source=source) from error
    if len(unpacked) > MOST:
        raise _too_long(source)
    return unpacked


def _from_gzip(content: bytes, source: str) -> bytes:
    unpacker = zlib.decompressobj(wbits=31)
    try:
        unpacked = unpacker.decompress(content, MOST + 1)
    except zlib.error as error:
        raise DamagedLog(f"found a gzip that cannot be unpacked ({error})", source=source) from error
    if len(unpacked) > MOST:
        raise _too_long(source)
    if not unpacker.eof:
        raise DamagedLog("found a gzip that ends early, expected the whole of it", source=source)
    return unpacked


def _too_long(source: str) -> DamagedLog:
    return DamagedLog(f"unpacks to more than {MOST // 2**20} MiB, expected a design", source=source)
