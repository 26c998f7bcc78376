"""Makes the pictures of the README, the output of `fieldkit demo` and pages of the app: `python tools/pictures.py`."""

import asyncio
import html
import io
import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console
from rich.terminal_theme import MONOKAI
from rich.text import Text

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "demo.svg"
WIDTH = 80
STEPS = 3
"""The steps of the demo in the picture."""


def demo() -> str:
    """The output of `fieldkit demo` in a terminal 80 columns wide, with its colors."""
    environment = {**os.environ, "COLUMNS": str(WIDTH), "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    command = [sys.executable, "-m", "fieldkit.cli.main", "demo"]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


def picture(text: str) -> str:
    """A terminal with this text as SVG, in any monospaced font: no font is downloaded."""
    console = Console(record=True, width=WIDTH, file=io.StringIO(), force_terminal=True)
    console.print(Text.assemble(("$ ", "bold green"), "fieldkit demo"))
    console.print(Text.from_ansi(text))
    return tidied(console.export_svg(title="fieldkit demo", theme=MONOKAI, unique_id="demo"))


def tidied(svg: str) -> str:
    """A picture without fonts to download, each word at its position."""
    svg = re.sub(r"@font-face\s*\{.*?\}\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r'(<text [^>]*?x=")([\d.]+)("[^>]*?textLength=")([\d.]+)("[^>]*>)([^<]*)</text>', _spaced, svg)
    return "".join(f"{line.rstrip()}\n" for line in svg.splitlines())


def _spaced(run: re.Match[str]) -> str:
    """A run of text as its words, each at its position, because some viewers drop leading spaces."""
    start, x, middle, length, end, content = run.groups()
    text = html.unescape(content)
    width = float(length) / len(text)
    words = []
    for word in re.finditer(r"[^\s\xa0]+", text):
        place = f"{start}{float(x) + word.start() * width:g}{middle}{len(word[0]) * width:g}{end}"
        words.append(f"{place}{html.escape(word[0])}</text>")
    return "".join(words)


LOG = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
PAGES = {
    "app_next": ("field", ["4", "_", "g", *"800ft", "enter", "_"]),
    "app_add": ("sun", ["a", "_", *"923ft", "enter", *"140mph", "enter", *"2.14", "enter", *"7.9", "enter", *"2.98"]),
    "app_flight": ("field", ["enter"]),
}
"""Pages of the app in the README: their colors, and the keys to press; `_` waits."""
SIZE = (100, 34)
"""Size of the terminal in the pictures."""


async def app_page(ledger: Path, theme: str, keys: list[str]) -> str:
    """A page of the app as SVG, after pressing keys."""
    from textual.pilot import Pilot  # only needed for pictures

    from fieldkit.tui.app import FieldkitApp

    async def calm(pilot: Pilot[None]) -> None:
        quiet = 0
        while quiet < 3:
            await pilot.pause()
            quiet = 0 if any(not worker.is_finished for worker in pilot.app.workers) else quiet + 1
            await asyncio.sleep(0.02)

    app = FieldkitApp(ledger, ledger.with_name("settings.json"))
    async with app.run_test(size=SIZE) as pilot:
        app.choose(theme=theme, units="US")
        app.action_read()
        await calm(pilot)
        for key in keys:
            await (calm(pilot) if key == "_" else pilot.press({".": "full_stop"}.get(key, key)))
        await calm(pilot)
        app.notices.clear()
        app.action_read()
        await calm(pilot)
        return tidied(app.export_screenshot(title="fieldkit"))


def app_pages() -> None:
    """Write the pictures of the app, over the reference flights and one log."""
    from fieldkit.ledger import Ledger
    from fieldkit.services.imports import bring_in

    for name, (theme, keys) in PAGES.items():
        with TemporaryDirectory() as folder:
            file = Path(folder) / "ledger.db"
            with Ledger.open(file) as ledger:
                bring_in(ledger, [ROOT / "fieldkit" / "data" / "reference_flights.csv"], lambda name: None)
                if name == "app_flight":
                    known = {"rocket": "Comet", "motor": "F24-4W", "dry_mass": 0.3, "diameter": 0.098}
                    (logged,) = bring_in(ledger, [LOG], lambda name: None, defaults=known).ids
                    ledger.edit(logged, flight_id="13")
            path = ROOT / "docs" / f"{name}.svg"
            path.write_text(asyncio.run(app_page(file, theme, keys)), encoding="utf-8")
            print(path)


def main() -> None:
    """Write the pictures."""
    app_pages()
    steps = re.split(rf"^{STEPS + 1}\. ", demo(), flags=re.MULTILINE)
    PICTURE.write_text(picture(steps[0].rstrip()), encoding="utf-8")
    print(PICTURE)


if __name__ == "__main__":
    main()
