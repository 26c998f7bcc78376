"""Text from a log or a table, made harmless for a terminal, for a spreadsheet and for a page of Markdown.

The ledger keeps a text as it came; a screen or a message shows it through `printable`, a table that is exported
holds it as `as_cell`, a page `as_markdown`. Square brackets stay: what draws with rich wraps a text in
`rich.text.Text` or `rich.markup.escape`.
"""

import re
import unicodedata

_BLANK = {ord(c): " " for c in "\t\n\v\f\r\x1c\x1d\x1e\x1f\x85\u2028\u2029"}
_JOINERS = "\u200c\u200d"
"""Zero-width (non-)joiners shape letters and emoji and cannot move the text around them."""


def _picture(char: str) -> str:
    """What stands for a character that must not reach a terminal, or the character itself."""
    code = ord(char)
    if unicodedata.category(char) not in ("Cc", "Cf", "Cs", "Co") or char in _JOINERS:
        return char
    if code < 0x20:
        return chr(0x2400 + code)
    return "\u2421" if code == 0x7F else f"<U+{code:04X}>"


def printable(text: str) -> str:
    """A text on one line that can neither move the cursor, nor color, nor reverse what is around it.

    Line breaks and tabs become blanks; an escape sequence shows as `␛[31m`, a mark that changes the
    writing direction or hides itself as its number, `<U+202E>`. Other text is unchanged.
    """
    return text if text.isprintable() else "".join(map(_picture, text.translate(_BLANK)))


_FORMULA = re.compile("'*[=+\\-@\t\r\n\uff1d\uff0b\uff0d\uff20]")
"""How a cell begins that a spreadsheet may compute, the full-width signs among them.

Source: OWASP, CSV Injection, https://owasp.org/www-community/attacks/CSV_Injection.
"""


def as_cell(text: str) -> str:
    """A text for a cell of a table, with an apostrophe before what a spreadsheet would take for a formula."""
    return f"'{text}" if _FORMULA.match(text) else text


def from_cell(cell: str) -> str:
    """The text that `as_cell` made a cell of."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell


def as_markdown(text: str) -> str:
    """A text that Markdown takes for nothing but text: on one line, its marks escaped, no tags and no links.

    Source: CommonMark 0.31, 2.4: any ASCII punctuation may be escaped with a backslash.
    """
    plain = printable(text).replace("&", "&amp;").replace("<", "&lt;")
    quoted = re.sub(r"([\\`*_{}\[\]()#!|~^=>$]|^[+-](?=[+\s-]|$))", r"\\\1", plain)
    return re.sub(r"(?i)\b(https?|ftp|mailto)(?=:)|(?<=www)\.|@|^(\d+)\.(?=\s|$)", _unlinked, quoted)


def _unlinked(mark: re.Match[str]) -> str:
    """What some readers of Markdown would make a link or a list of, as characters by number."""
    text = mark.group()
    return text[:-1] + f"&#{ord(text[-1])};"
