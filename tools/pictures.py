"""Makes the pictures of the README and of the manual, pages of the app: `python tools/pictures.py`.

`python tools/pictures.py FOLDER [NAME ...]` draws instead every page, or those named, in each size and theme, to be
looked at.
"""

import argparse
import asyncio
import html
import os
import re
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]


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
SIZE = (120, 36)
"""Size of the terminal in the pictures. [cell]"""
SIZES = ((80, 24), (120, 36), (160, 50), (250, 70))
LOOKS = ("field", "sun", "night")
"""Sizes [cell] and themes in which every page is drawn."""
MEASURED = [*"543", "enter", *"121", "enter", *"1.15", "enter", *"9.2", "enter", *"5.6"]
"""Readouts typed on the Add page."""
SEARCHED = ["5", "_", "b", "_", "S", "_", "_"]
"""Keys of a search on the Loop page."""
EVERY_PAGE: dict[str, list[str]] = {
    "home": ["0", "_"],
    "flights": ["1", "_", "down"],
    "flight": ["1", "_", "end", "_", "enter", "_"],
    "flight_with_log": ["1", "_", "home", "_", "enter", "_"],
    "log": ["1", "_", "home", "_", "enter", "_", "end", "_", "l", "_"],
    "tags": ["1", "_", "end", "t", "_"],
    "add": ["a", "_", *MEASURED],
    "added": ["a", "_", *MEASURED, "ctrl+s", "_"],
    "import": ["3", "_"],
    "next": ["4", "_"],
    "next_target": ["4", "_", "g", *"800ft", "enter", "_"],
    "compare": ["4", "_", "c", "_"],
    "plan": ["p", "_"],
    "delay": ["4", "_", "d", "_"],
    **{
        name: ["4", "_", "d", "_", *["right", "_"] * turns]
        for turns, name in enumerate(("ballast", "contest", "landing", "saved", "score", "season", "finals"), start=1)
    },
    "loop_before": ["5", "_"],
    "loop": SEARCHED,
    "loop_flights": [*SEARCHED, "right"],
    "evidence": [*SEARCHED, "right", "right", "right"],
    "residuals": [*SEARCHED, "v"],
    "fingerprint": [*SEARCHED, "n"],
    "setup": ["6", "_"],
    "rockets": ["6", "_", "right", "_"],
    "sites": ["6", "_", "right", "right", "_"],
    "kits": ["6", "_", "left", "left", "_"],
    "settings": ["6", "_", "left", "_"],
    "capture": ["7", "_"],
    "weather": ["0", "_", "e", "_"],
    "edit": ["1", "_", "end", "e", "_"],
    "pad": ["K", "_"],
    "help": ["question_mark"],
    "palette": ["ctrl+p", "_", *"landing", "_"],
}
"""Every page of the app, and the keys that open it."""


KITS = '["Big Bertha"]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n'
"""A file with a kit."""


async def app_page(ledger: Path, themes: Sequence[str], keys: list[str], size: tuple[int, int] = SIZE) -> list[str]:
    """A page of the app as SVG in each theme, after pressing keys."""
    from textual.pilot import Pilot  # only needed for pictures

    from fieldkit.tui.app import FieldkitApp

    async def calm(pilot: Pilot[None]) -> None:
        quiet = 0
        while quiet < 3:
            await pilot.pause()
            quiet = 0 if any(not worker.is_finished for worker in pilot.app.workers) else quiet + 1
            await asyncio.sleep(0.02)

    drawn = []
    app = FieldkitApp(ledger, ledger.with_name("settings.json"))
    async with app.run_test(size=size) as pilot:
        app.choose(theme=themes[0], units="US")
        app.action_read()
        await calm(pilot)
        for key in keys:
            await (calm(pilot) if key == "_" else pilot.press({".": "full_stop"}.get(key, key)))
        for theme in themes:
            app.choose(theme=theme)
            app.notices.clear()
            app.action_read()
            await calm(pilot)
            drawn.append(tidied(app.export_screenshot(title="fieldkit")))
    return drawn


def app_pages() -> None:
    """Write the pictures of the app, over the reference flights and one log."""
    for name, (theme, keys) in PAGES.items():
        with TemporaryDirectory() as folder:
            path = ROOT / "docs" / f"{name}.svg"
            ledger = _season(Path(folder), logged=name == "app_flight")
            (drawn,) = asyncio.run(app_page(ledger, [theme], keys))
            path.write_text(drawn, encoding="utf-8")
            print(path)


def every_page(out: Path, names: list[str]) -> None:
    """Write every page, or those named, in each size and theme: `next-80x24-sun.svg`."""
    out.mkdir(parents=True, exist_ok=True)
    for name in names or EVERY_PAGE:
        for size in SIZES:
            with TemporaryDirectory() as folder:
                ledger = _season(Path(folder), logged=True)
                os.environ["FIELDKIT_HOME"] = folder
                ledger.with_name("kits.toml").write_text(KITS, encoding="utf-8")
                drawn = asyncio.run(app_page(ledger, LOOKS, EVERY_PAGE[name], size))
            for look, svg in zip(LOOKS, drawn, strict=True):
                path = out / f"{name}-{size[0]}x{size[1]}-{look}.svg"
                path.write_text(svg, encoding="utf-8")
                print(path)


def _season(folder: Path, *, logged: bool) -> Path:
    """A ledger of the reference flights in a folder, with one log."""
    from fieldkit.ledger import Ledger
    from fieldkit.services.imports import bring_in

    file = folder / "ledger.db"
    with Ledger.open(file) as ledger:
        bring_in(ledger, [ROOT / "fieldkit" / "data" / "reference_flights.csv"], lambda name: None)
        if logged:
            known = {"rocket": "Comet", "motor": "F24-4W", "dry_mass": 0.3, "diameter": 0.098}
            (flight,) = bring_in(ledger, [LOG], lambda name: None, defaults=known).ids
            ledger.edit(flight, flight_id="13")
    return file


def main() -> None:
    """Write the pictures."""
    parser = argparse.ArgumentParser(description="Draw the pictures of the README and of the manual.")
    parser.add_argument("folder", nargs="?", type=Path, help="Draw pages in every size and theme into this folder.")
    parser.add_argument("name", nargs="*", help=f"Pages to draw there, by default all: {', '.join(EVERY_PAGE)}.")
    options = parser.parse_args()
    if unknown := set(options.name) - EVERY_PAGE.keys():
        parser.error(f"no page {', '.join(sorted(unknown))}")
    if options.folder:
        every_page(options.folder, options.name)
    else:
        app_pages()


if __name__ == "__main__":
    main()
