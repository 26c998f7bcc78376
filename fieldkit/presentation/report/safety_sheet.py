"""The range safety sheet: one page that a range safety officer signs, with what was checked, by which rule, and what is
not known."""

from collections.abc import Iterator, Sequence
from textwrap import wrap

from fieldkit.messages import message
from fieldkit.planning.check import ADVICE_NOTE, MARKS, SafetyCheck, worst_first
from fieldkit.presentation.report.range_card import FONT, LINE, NOTE_INDENT, ROW, fitted
from fieldkit.presentation.report.style import A4, drawn, without_markup
from fieldkit.quantities import in_system
from fieldkit.safe_text import printable

SIGNATURES = (
    "Checked on the range: stability ____   motor and igniter ____   recovery ____   rail and angle ____   sky ____",
    "Range safety officer ______________________________   date and time ____________________   flies: yes / no",
)
"""What is filled in by hand."""
UNVERIFIED = "unverified"
"""The mark of a rule that was written down from memory."""
TOP, FOOT_OF_PAGE = 0.965, 0.09
"""Highest position of the text and the room for signatures, as fractions of the page's height. [1]"""


def sheet_text(lines: Sequence[SafetyCheck], system: str = "SI") -> Iterator[str]:
    """The sections of the sheet: failed and passed checks with their rule and source, what is not known, and what is
    checked by eye; amounts in the units of a system."""
    judged = worst_first(one for one in lines if one.verdict != "unknown")
    yield f"CHECKED ({len(judged)}), by rule and source"
    for one in judged:
        basis = "; ".join(part for part in (one.rule, one.source) if part) or "no rule needed"
        found = in_system(message(one.finding), system)
        yield f"  {MARKS[one.verdict]} {one.name}: {one.verdict}: {found}{one.suffix} [{basis}]"
    missing = [one for one in lines if one.verdict == "unknown" and not one.by_eye]
    yield ""
    yield f"NOT KNOWN ({len(missing)})"
    for one in missing:
        yield f"  {MARKS[one.verdict]} {one.name}: {in_system(message(one.finding), system)}{one.suffix}"
    by_eye = [one for one in lines if one.by_eye]
    yield ""
    yield f"CHECKED BY EYE ON THE RANGE ({len(by_eye)})"
    for one in by_eye:
        yield f"  [ ] {one.name}: {in_system(message(one.finding), system).partition(': ')[2]}"
    yield ""
    if any(UNVERIFIED in f"{one.finding}{one.suffix}" for one in lines):
        yield f"{UNVERIFIED.capitalize()}: no source of it was at hand; read the current code."
    yield ADVICE_NOTE


@without_markup()
def safety_sheet(heading: Sequence[str], lines: Sequence[SafetyCheck], suffix: str, system: str = "SI") -> bytes:
    """The sheet as a picture of a page: a heading, whose first line is the title, the checks, and room to sign."""
    from matplotlib.figure import Figure  # takes 40 MB of the app's memory

    title, *rest = map(printable, heading)
    about = [line for text in rest for line in wrap(text, LINE, subsequent_indent=" " * NOTE_INDENT)]
    figure = Figure(figsize=A4)
    figure.text(0.06, TOP, f"Range safety sheet: {title}", fontsize=12, fontweight="bold", va="top")
    figure.text(0.06, TOP - 0.025, "\n".join(about), fontsize=FONT, va="top", family="monospace")
    top = TOP - 0.025 - ROW * (len(about) + 1)
    text, size = fitted(list(sheet_text(lines, system)), (top - FOOT_OF_PAGE) / ROW)
    figure.text(0.06, top, text, fontsize=size, va="top", family="monospace")
    for place, line in enumerate(reversed(SIGNATURES)):
        figure.text(0.06, 0.03 + 0.03 * place, line, fontsize=8)
    return drawn(figure, suffix.lstrip("."), dpi=130)
