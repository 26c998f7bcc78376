"""Makes the picture of the README, `docs/demo.svg`, from what `fieldkit demo` prints: `python tools/pictures.py`."""

import html
import io
import os
import re
import subprocess
import sys
from pathlib import Path

from rich.console import Console
from rich.terminal_theme import MONOKAI
from rich.text import Text

PICTURE = Path(__file__).parents[1] / "docs" / "demo.svg"
WIDTH = 80
STEPS = 3
"""The steps of the demo that the picture holds."""


def demo() -> str:
    """What `fieldkit demo` prints in a terminal 80 columns wide, with its colours."""
    environment = {**os.environ, "COLUMNS": str(WIDTH), "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    command = [sys.executable, "-m", "fieldkit.cli.main", "demo"]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


def picture(text: str) -> str:
    """A terminal with this text as SVG, in whatever monospaced font there is: nothing is fetched."""
    console = Console(record=True, width=WIDTH, file=io.StringIO(), force_terminal=True)
    console.print(Text.assemble(("$ ", "bold green"), "fieldkit demo"))
    console.print(Text.from_ansi(text))
    svg = console.export_svg(title="fieldkit demo", theme=MONOKAI, unique_id="demo")
    svg = re.sub(r"@font-face\s*\{.*?\}\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r'(<text [^>]*?x=")([\d.]+)("[^>]*?textLength=")([\d.]+)("[^>]*>)([^<]*)</text>', _apart, svg)
    return "".join(f"{line.rstrip()}\n" for line in svg.splitlines())


def _apart(run: re.Match[str]) -> str:
    """A run of text as its words, each in its place: not every viewer keeps blanks in front of a text."""
    start, x, middle, length, end, content = run.groups()
    text = html.unescape(content)
    width = float(length) / len(text)
    words = []
    for word in re.finditer(r"[^\s\xa0]+", text):
        place = f"{start}{float(x) + word.start() * width:g}{middle}{len(word[0]) * width:g}{end}"
        words.append(f"{place}{html.escape(word[0])}</text>")
    return "".join(words)


def main() -> None:
    """Write the picture."""
    steps = re.split(rf"^{STEPS + 1}\. ", demo(), flags=re.MULTILINE)
    PICTURE.write_text(picture(steps[0].rstrip()), encoding="utf-8")
    print(PICTURE)


if __name__ == "__main__":
    main()
