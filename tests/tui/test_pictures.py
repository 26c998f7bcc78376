"""How every page looks after some keys, in one theme and three sizes, and whether all themes are readable."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from pytest_textual_snapshot import SVGImageExtension
from rich.color import Color, ColorType
from rich.segment import Segment
from syrupy.assertion import SnapshotAssertion
from textual.color import Color as TextualColor
from textual.pilot import Pilot

from fieldkit import settings
from fieldkit.ledger import Ledger
from fieldkit.services.imports import bring_in
from fieldkit.services.typed_flight import TypedEstimate
from fieldkit.tui.themes import THEMES
from tests.pressing import ROOT, calm, frozen, looked_at, opened, press, season, shown, typed

CHECK_SHAPES = False

THEME = "field"
"""The theme of all pictures; the others differ in colors alone, and those are checked without pictures."""
SIZES = ((80, 24), (120, 36), (160, 50))
SCENES: dict[str, tuple[str, ...]] = {
    "home": ("0", "_"),
    "flights": ("down", "slash", *typed("f24"), "enter"),
    "flight": ("end", "up", "enter"),
    "log": ("slash", *typed("comet"), "enter", "enter", "end"),
    "tags": ("end", "up", "t", "down", "enter"),
    "add": ("a", *typed("923ft"), "enter", *typed("140mph"), "enter", *typed("2.x"), "enter", *typed("7.9")),
    "import": ("3", "end"),
    "next": ("4", "_", "g", *typed("240m"), "enter", "_", "down"),
    "plan": ("4", "_", "p", "down", "down", *typed("4oog"), "down"),
    "decide": ("4", "_", "slash", *typed("f24"), "enter", "_", "d"),
    "compare": ("4", "_", "g", *typed("240m"), "enter", "_", "c"),
    "loop": ("5", "_", "S", "_", "c"),
    "setup": ("6", "right", "_", "left", "slash", *typed("f24"), "enter"),
    "build": ("6", "right", "enter", "down"),
    "sites": ("6", "right", "right"),
    "settings": ("6", "left", "down"),
    "capture": ("7",),
    "help": ("question_mark",),
    "notices": ("3", "m"),
}
OVERLAID = ("help", "plan", "build")
"""Scenes in which the page behind is dimmed on purpose, in the theme that dims."""
IN_EVERY_THEME = ("home", "flight", "add", "settings")
"""Scenes that show every kind of widget: tables, plots and densities, forms with notes, tabs."""
LOG = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
ESTIMATE = TypedEstimate(cd=(0.39, 0.61, 0.93), alpha=(0.82, 0.92, 1.03), next_apogee=(156.2, 204.1, 262.3), flights=1)
LEAST = {"sun": 7.0, "night": 7.0, "field": 7.0}
"""Minimum contrast of every letter with its background, as defined in WCAG 2.2."""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    folder = tmp_path / "field"
    folder.mkdir()
    season(tmp_path / "ledger.db")
    (folder / "a season.csv").write_text("flight_id,rocket,motor,apogee_m\n1,Comet,C6-5,1o4\n2,Comet,C6-5,210\n")
    monkeypatch.chdir(folder)
    monkeypatch.setattr("fieldkit.capture.ports", list)
    monkeypatch.setattr("fieldkit.tui.imports.import_page.folder_text", lambda folder: folder.name)
    monkeypatch.setattr("fieldkit.tui.setup.setup_lists.motor_folder", lambda: Path("/home/flyer/motors"))
    monkeypatch.setattr("fieldkit.tui.setup.setup_lists.settings_file", lambda: Path("/home/flyer/settings.json"))
    monkeypatch.setattr("fieldkit.tui.resources.Resources.name", "/home/flyer/ledger.db")
    return tmp_path / "ledger.db"


@pytest.fixture(autouse=True)
def _first_forecasts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The finer forecast under the cursor and why a flight missed, which come when keys have rested a while, are not
    waited for; and the estimate of a flight as it is typed is a fixed one, since the last digit of the network depends
    on the processor."""
    monkeypatch.setattr("fieldkit.tui.next.next_page.REST", 3600.0)
    monkeypatch.setattr("fieldkit.tui.flights.flights_page.REST", 3600.0)
    monkeypatch.setattr("fieldkit.services.typed_flight.TypedFlight.estimate", lambda self, typed: ESTIMATE)


def pictures() -> Iterator[Any]:
    """Every scene in one size, and in the others in the thorough run."""
    for number, scene in enumerate(SCENES):
        for place, size in enumerate(SIZES):
            marks = () if place == number % len(SIZES) else pytest.mark.thorough
            yield pytest.param(scene, size, id=f"{scene}-{size[0]}x{size[1]}", marks=marks)


@pytest.mark.parametrize(("scene", "size"), pictures())
async def test_a_page_looks_as_it_did_and_can_be_read(
    scene: str, size: tuple[int, int], file: Path, snapshot: SnapshotAssertion
) -> None:
    if scene == "log":
        with Ledger.open(file) as ledger:
            bring_in(ledger, [LOG], lambda name: None, defaults={"rocket": "Comet"})
    with patch("fieldkit.tui.loop.loop_page.look", lambda resources, rocket, on_progress: looked_at()):
        async with opened(file, size) as pilot:
            await press(pilot, *SCENES[scene])
            picture = pilot.app.export_screenshot(title="fieldkit")
            assert snapshot(name=THEME, extension_class=SVGImageExtension) == picture
            if scene not in OVERLAID:
                assert not list(unreadable(pilot, THEME))


@pytest.mark.parametrize("scene", IN_EVERY_THEME)
async def test_a_page_is_readable_in_every_other_theme(scene: str, file: Path) -> None:
    async with opened(file, SIZES[-1]) as pilot:
        await press(pilot, *SCENES[scene])
        for theme in set(LEAST) - {THEME}:
            pilot.app.theme = theme
            await calm(pilot)
            assert not list(unreadable(pilot, theme)), theme


async def test_the_theme_of_the_settings_is_there_from_the_start(file: Path) -> None:
    settings.change_settings({"theme": "sun"}, file.with_name("settings.json"))
    async with opened(file) as pilot:
        assert {"-theme-sun", "-light-mode"} <= set(pilot.app.classes)
        assert pilot.app.screen.styles.background.rgb == (255, 255, 255)


async def test_the_palette_is_readable_in_the_sun_theme(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "T", "escape", "ctrl+p")
        assert "Search for commands" in shown(pilot)
        assert not list(unreadable(pilot, "sun"))


def unreadable(pilot: Pilot[None], theme: str) -> Iterator[str]:
    """Texts on the screen that lack contrast, or are dimmed."""
    for segment in segments(pilot):
        text, style = segment.text.strip(), segment.style
        if not text or style is None or style.color is None or style.bgcolor is None:
            continue
        if theme != "sun" and not any(map(str.isalnum, text)):
            continue  # frames and bars; in the sun they are as black as the letters
        ratio = contrast(style.color, style.bgcolor)
        if ratio < LEAST[theme] or (style.dim and theme == "sun"):
            yield f"{text!r} {ratio:.2f}"


def segments(pilot: Pilot[None]) -> Iterator[Segment]:
    for strip in pilot.app.screen._compositor.render_strips():
        yield from strip


def contrast(ink: Color, paper: Color) -> float:
    """By the relative luminance of two colors (WCAG 2.2, 1.4.3); letters of frames and blocks count as well."""
    lights = sorted(luminance(one) for one in (ink, paper))
    return (lights[1] + 0.05) / (lights[0] + 0.05)


def luminance(colour: Color) -> float:
    assert colour.type is ColorType.TRUECOLOR
    assert colour.triplet is not None
    parts = [part / 255 for part in colour.triplet]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_settings_and_the_app_name_the_same_themes() -> None:
    assert tuple(THEMES) == settings.THEMES


PAIRS = (
    *((ink, paper) for ink in ("foreground", "text-muted", "primary", "accent", "error") for paper in ("background",)),
    *((ink, paper) for ink in ("foreground", "primary", "accent") for paper in ("surface", "panel")),
    *((state, paper) for state in ("success", "warning", "error") for paper in ("background", "surface")),
    ("border", "background"),
    ("text-disabled", "background"),
    ("footer-foreground", "footer-background"),
    ("footer-key-foreground", "footer-background"),
    ("block-cursor-foreground", "block-cursor-background"),
    ("block-cursor-blurred-foreground", "block-cursor-blurred-background"),
    ("input-cursor-foreground", "input-cursor-background"),
    ("input-selection-foreground", "input-selection-background"),
)
"""Variables of a theme: a text color, and the backgrounds that the app's style sheets put behind it."""


def variables(theme: str) -> dict[str, str]:
    """All colors of a theme, those that Textual derives included."""
    return THEMES[theme].to_color_system().generate()


@pytest.mark.parametrize("theme", LEAST)
def test_every_text_color_of_a_theme_has_contrast_with_its_background(theme: str) -> None:
    named = variables(theme)
    for ink, paper in PAIRS:
        behind = TextualColor.parse(named[paper])
        letters = behind + TextualColor.parse(named[ink])  # blended with the background, if it is translucent
        ratio = contrast(Color.from_rgb(*letters.rgb), Color.from_rgb(*behind.rgb))
        assert ratio >= LEAST[theme], f"{ink} on {paper}: {ratio:.2f}"


def test_the_sun_theme_is_opaque_text_on_white() -> None:
    named = variables("sun")
    assert TextualColor.parse(named["background"]).rgb == (255, 255, 255)
    for name in ("foreground", "primary", "accent", "error", "success", "text-muted", "text-disabled", "border"):
        assert TextualColor.parse(named[name]).a == 1, name


def test_the_terminal_theme_has_only_the_terminals_own_colors() -> None:
    named = variables("terminal")
    for name in {name for pair in PAIRS for name in pair}:
        assert named[name] == "transparent" or named[name].startswith("ansi_"), name


def test_style_sheets_name_no_colors() -> None:
    """All colors come from the theme, so its definition alone determines whether a page is readable."""
    values = []
    for path in sorted((ROOT / "fieldkit" / "tui").rglob("*.py")):
        values += re.findall(r"\b(?:color|background|border[\w-]*|tint): ([^;\n]+);", path.read_text(encoding="utf-8"))
    assert len(values) > 50
    assert not [value for value in values if not all(re.fullmatch(ALLOWED, part) for part in value.split())]


ALLOWED = (
    r"\$[\w-]+|\d+%|none|transparent|auto|round|solid|heavy|tall|wide|blank|thick|dashed|inner|outer|vkey|hkey"
    r"|left|center|right|!important"
)
"""Words of a style sheet that are not colors."""


def test_the_contrast_of_black_on_white_is_21() -> None:
    assert contrast(Color.from_rgb(0, 0, 0), Color.from_rgb(255, 255, 255)) == pytest.approx(21)
    assert contrast(Color.from_rgb(119, 119, 119), Color.from_rgb(255, 255, 255)) == pytest.approx(4.48, abs=0.01)
