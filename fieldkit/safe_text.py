"""Text from a log or a table, made safe for a terminal, a spreadsheet and Markdown.

The ledger stores the original text; screens and messages show it through `printable`, exported tables through
`as_cell`, and Markdown through `as_markdown`. Square brackets do not change: code that uses rich has to wrap text in
`rich.text.Text` or `rich.markup.escape`.
"""

import re
import unicodedata

_BLANKS = {ord(c): " " for c in "\t\n\v\f\r\x1c\x1d\x1e\x1f\x85\u2028\u2029"}
_JOINERS = "\u200c\u200d"
"""Zero-width (non-)joiners shape letters and emoji and cannot move the text around them."""


def _picture(char: str) -> str:
    """The replacement of a character that must not reach a terminal, or the character itself."""
    code = ord(char)
    if unicodedata.category(char) not in ("Cc", "Cf", "Cs", "Co") or char in _JOINERS:
        return char
    if code < 0x20:
        return chr(0x2400 + code)
    return "\u2421" if code == 0x7F else f"<U+{code:04X}>"


def printable(text: str) -> str:
    """The text on one line, unable to move the cursor or change colors or the writing direction.

    Line breaks and tabs become spaces; an escape sequence shows as `␛[31m`, an invisible or direction-changing
    character as its number, `<U+202E>`. Other text is unchanged.
    """
    return text if text.isprintable() else "".join(map(_picture, text.translate(_BLANKS)))


def whole_number(text: str) -> int | None:
    """The number that a few ASCII digits spell, None for any other text.

    `str.isdigit` also accepts superscripts, which `int` does not read, and more digits than `int` reads.
    """
    return int(text) if re.fullmatch("[0-9]{1,18}", text) else None


_FORMULA = re.compile("'*[=+\\-@\t\r\n\uff1d\uff0b\uff0d\uff20]")
"""First characters of a cell that a spreadsheet may compute, including full-width ones.

Source: OWASP, CSV Injection, https://owasp.org/www-community/attacks/CSV_Injection.
"""


def as_cell(text: str) -> str:
    """A text for a cell of a table, with an apostrophe before anything that a spreadsheet would read as a formula."""
    return f"'{text}" if _FORMULA.match(text) else text


def from_cell(cell: str) -> str:
    """The inverse of `as_cell`."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell


def as_markdown(text: str) -> str:
    """A text for Markdown on one line, with its markup escaped, without tags and links.

    Source: CommonMark 0.31, 2.4: any ASCII punctuation may be escaped with a backslash.
    """
    plain = printable(text).replace("&", "&amp;").replace("<", "&lt;")
    quoted = re.sub(r"([\\`*_{}\[\]()#!|~^=>$]|^[+-](?=[+\s-]|$))", r"\\\1", plain)
    return re.sub(r"(?i)\b(https?|ftp|mailto)(?=:)|(?<=www)\.|@|^(\d+)\.(?=\s|$)", _unlinked, quoted)


def _unlinked(mark: re.Match[str]) -> str:
    """Escapes some Markdown readers' automatic links and lists with numbered characters."""
    text = mark.group()
    return text[:-1] + f"&#{ord(text[-1])};"
