"""Extract the XML of a design: for `.ork` a zip with `rocket.ork` in it, a gzip, or plain XML.

Unpacking stops at `MAX_UNPACKED_SIZE`, and defusedxml rejects document types and entities, which can expand or access
other files. Everything that is counted in a file has a limit: files in the archive, elements and their nesting depth,
and the length of one piece of markup or text.
"""

import re
import zipfile
import zlib
from xml.etree.ElementTree import Element, ParseError, TreeBuilder

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from fieldkit import zips
from fieldkit.errors import DamagedLog

MAX_UNPACKED_SIZE = 64 * 2**20
"""Largest size of an unpacked file; a design with many stored simulations takes a few million bytes. [bytes]"""
MOST_ELEMENTS = 500_000
"""Largest number of elements in a design; a stored simulation has one for each of its few thousand samples. [1]"""
MAX_NESTED_ARCHIVES = 2
"""Number of archives around a design: its own, and one in which somebody sent it. [1]"""
MAX_DEPTH = 200
"""Largest nesting depth of elements; a part inside a part takes two. [1]"""
MAX_TAG_LENGTH = 1 << 20
"""Largest distance between the ends of consecutive tags: attributes and the text before them. [bytes]"""
DESIGNS = (".ork", ".rkt", ".cdx1")
"""Endings of designs in an archive, in lower case."""
ENCODINGS = ("utf-8", "utf-16", "us-ascii", "ascii", "iso-8859-1", "latin-1", "windows-1252", "cp1252")
"""Encodings in which tags can be found without decoding."""

_DECLARED_ENCODING = re.compile(rb"^\s*<\?xml[^>]{0,200}?encoding\s{0,9}=\s{0,9}[\"']([\w.-]{1,40})")


def root_of(content: bytes, source: str) -> Element:
    """The root element of a file with a design. Raises DamagedLog that names the file, and the row of an XML error."""
    text = _unpacked(content, source)
    if text and b"<" not in text[:400]:
        found = "found no XML, as very old versions save it, expected a design; save it again with a newer version"
        raise DamagedLog(found, source=source)
    _check_markup(text, source)
    parser = DefusedXMLParser(target=_builder(source), forbid_dtd=True)
    try:
        parser.feed(text)
        root: Element = parser.close()
    except ParseError as error:
        row, _ = error.position
        raise DamagedLog(f"found broken XML ({str(error).split(':')[0]})", row=row, source=source) from error
    except DefusedXmlException as error:
        found = "found a document type or entities, expected plain XML without <!DOCTYPE>"
        raise DamagedLog(found, source=source) from error
    except (LookupError, ValueError) as error:
        raise DamagedLog(f"found an encoding that cannot be read ({error})", source=source) from error
    return root


def _check_markup(text: bytes, source: str) -> None:
    """Raise DamagedLog for pieces of markup that are too long to parse, or an encoding that hides the markup."""
    declared = _DECLARED_ENCODING.match(text[:400])
    if declared and declared[1].decode().lower() not in ENCODINGS:
        raise DamagedLog(f"found the encoding {declared[1].decode()}, expected UTF-8", source=source)
    if text.count(b">") > 4 * MOST_ELEMENTS:
        raise _too_many(source)
    start = 0
    while start < len(text):
        end = text.find(b">", start, start + MAX_TAG_LENGTH)
        if end < 0 and len(text) - start > MAX_TAG_LENGTH:
            found = f"found {MAX_TAG_LENGTH >> 20} MiB without the end of a tag, expected a design"
            raise DamagedLog(found, row=text.count(b"\n", 0, start) + 1, source=source)
        start = end + 1 if end >= 0 else len(text)


def _builder(source: str) -> TreeBuilder:
    """A builder of the element tree that stops if there are too many elements or they are nested too deeply."""

    class Bounded(TreeBuilder):
        count = depth = 0

        def start(self, tag: str, attributes: dict[str, str]) -> Element:
            self.count, self.depth = self.count + 1, self.depth + 1
            if self.count > MOST_ELEMENTS:
                raise _too_many(source)
            if self.depth > MAX_DEPTH:
                raise DamagedLog(f"found elements nested more than {MAX_DEPTH} deep, expected a design", source=source)
            return super().start(tag, attributes)

        def end(self, tag: str) -> Element:
            self.depth -= 1
            return super().end(tag)

    return Bounded()


def _too_many(source: str) -> DamagedLog:
    return DamagedLog(f"found more than {MOST_ELEMENTS} elements, expected a design", source=source)


def _unpacked(content: bytes, source: str) -> bytes:
    """The XML of a design, which may be zipped once more, without the padding that editors and mail add around it."""
    for _ in range(MAX_NESTED_ARCHIVES):
        if content.startswith(b"PK"):
            content = _from_zip(content, source)
        elif content.startswith(b"\x1f\x8b"):
            content = _from_gzip(content, source)
    if len(content) > MAX_UNPACKED_SIZE:
        raise _too_long(source)
    is_wide = b"\0" in content[:4]
    return content if is_wide else content.lstrip(b" \t\r\n").rstrip(b"\0\x1a")


def _from_zip(content: bytes, source: str) -> bytes:
    try:
        with zips.opened(content) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(DESIGNS) and "__MACOSX" not in name]
            if not names:
                raise DamagedLog("found a zip without a design in it, expected a .ork, .rkt or .CDX1", source=source)
            with archive.open("rocket.ork" if "rocket.ork" in names else names[0]) as file:
                unpacked = file.read(MAX_UNPACKED_SIZE + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as error:
        raise DamagedLog(f"found a zip that cannot be unpacked ({error})", source=source) from error
    if len(unpacked) > MAX_UNPACKED_SIZE:
        raise _too_long(source)
    return unpacked


def _from_gzip(content: bytes, source: str) -> bytes:
    unpacker = zlib.decompressobj(wbits=31)
    try:
        unpacked = unpacker.decompress(content, MAX_UNPACKED_SIZE + 1)
    except zlib.error as error:
        raise DamagedLog(f"found a gzip that cannot be unpacked ({error})", source=source) from error
    if len(unpacked) > MAX_UNPACKED_SIZE:
        raise _too_long(source)
    if not unpacker.eof:
        raise DamagedLog("found a gzip that ends early, expected a complete one", source=source)
    return unpacked


def _too_long(source: str) -> DamagedLog:
    return DamagedLog(f"unpacks to more than {MAX_UNPACKED_SIZE // 2**20} MiB, expected a design", source=source)
