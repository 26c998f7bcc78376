"""Answers offered below an input: arrows or a click choose one, Enter accepts it, Esc closes the list.

A screen that centers its form gives the list a layer `above`: in the same layer as the form, Textual centers both
together, which moves the form up and its line under the list.
"""

from collections.abc import Mapping, Sequence

from textual import on
from textual.content import Content
from textual.geometry import Offset
from textual.widgets import Input, OptionList
from textual.widgets.option_list import Option

from fieldkit.safe_text import printable
from fieldkit.services.pickers import OfferedAnswer, Source

MIN_WIDTH, MAX_WIDTH = 24, 56
"""Smallest and largest width of the list. [cell]"""


class Picker(OptionList, can_focus=False):
    """The list of one form, below the current input, which keeps the focus."""

    DEFAULT_CSS = """
    Picker { display: none; layer: above; overlay: screen; constrain: inside inflect; height: auto; max-height: 10;
        width: 24; border: round $border; background: $surface; color: $foreground; padding: 0;
        scrollbar-size-vertical: 1; }
    Picker.-open { display: block; }
    Picker > .option-list--option-highlighted { color: $block-cursor-foreground;
        background: $block-cursor-background; text-style: bold; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._line: Input | None = None
        self._picks: Sequence[OfferedAnswer] = ()
        self._taken = ""
        self.sources: Mapping[str, Source] = {}
        """Offered answers by question."""

    @property
    def open(self) -> bool:
        """Whether the list is visible."""
        return self.has_class("-open")

    def follow(self, line: Input, name: str) -> None:
        """Offer answers that match the text of an input; `name` is that of its question."""
        source = self.sources.get(name)
        text = line.value.strip()
        if source is None or not line.has_focus or (text and text == self._taken):
            self.close()
            return
        self._taken = ""
        self._line, self._picks = line, source(text)
        if not self._picks or [pick.text for pick in self._picks] == [text]:
            self.close()
            return
        self.clear_options()
        self.add_options(Option(_shown(pick)) for pick in self._picks)
        self.highlighted = None
        longest = max(len(pick.text) + len(pick.about) for pick in self._picks) + 6
        self.styles.width = min(max(longest, MIN_WIDTH), MAX_WIDTH)
        self.absolute_offset = Offset(line.region.x, line.region.bottom)
        self.add_class("-open")

    def move(self, by: int) -> None:
        """Move to the next or previous answer; above the first one is the input."""
        at = (-1 if self.highlighted is None else self.highlighted) + by
        self.highlighted = None if at < 0 else min(at, len(self._picks) - 1)

    def take(self, *, only: bool = False) -> bool:
        """Put the chosen answer in the input, or the only one offered if `only`; False if none is chosen."""
        if only and self.highlighted is None and len(self._picks) == 1:
            self.highlighted = 0
        if not self.open or self.highlighted is None or self._line is None:
            self.close()
            return False
        self._taken = self._picks[self.highlighted].text
        self._line.value = printable(self._taken)
        self._line.cursor_position = len(self._line.value)
        self.close()
        return True

    def offer_more(self, name: str) -> None:
        """Offer what can follow the answer that was just chosen."""
        self._taken = ""
        if self._line is not None:
            self.follow(self._line, name)

    def close(self) -> None:
        """Hide the list."""
        self.remove_class("-open")

    @on(OptionList.OptionSelected)
    def _clicked(self, message: OptionList.OptionSelected) -> None:
        message.stop()
        self.highlighted = message.option_index
        self.take()


def _shown(pick: OfferedAnswer) -> Content:
    return Content.assemble((printable(pick.text), "b"), f"  {printable(pick.about)}" if pick.about else "")
