"""How every page looks after keys were pressed, in every theme and in two sizes, and that all of it can be read."""

from collections.abc import Iterator
from pathlib import Path
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
from fieldkit.tui.themes import SUN, THEMES
from tests.pressing import ROOT, calm, frozen, looked_at, opened, press, season, shown, typed

CHECK_SHAPES = False

SIZES = ((80, 24), (160, 50))
SCENES: dict[str, tuple[str, ...]] = {
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
    "loop": ("5", "_", "l", "_", "c"),
    "setup": ("6", "right", "_", "left", "slash", *typed("f24"), "enter"),
    "build": ("6", "right", "enter", "down"),
    "sites": ("6", "right", "right"),
    "settings": ("6", "left", "down"),
    "capture": ("7",),
    "help": ("question_mark",),
    "notices": ("4", "_", "g", *typed("far"), "enter"),
}
OVERLAID = ("help", "plan", "build")
"""Scenes in which the page behind is dimmed on purpose, in the theme that dims."""
LOG = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
LEAST = {"sun": 7.0, "night": 6.0, "field": 4.5}
"""Contrast of every letter against what is behind it, as WCAG 2.2 counts it."""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    folder = tmp_path / "field"
    folder.mkdir()
    season(tmp_path / "ledger.db")
    (folder / "a season.csv").write_text("flight_id,rocket,motor,apogee_m\n1,Comet,C6-5,1o4\n2,Comet,C6-5,210\n")
    monkeypatch.chdir(folder)
    monkeypatch.setattr("fieldkit.capture.ports", list)
    monkeypatch.setattr("fieldkit.tui.screens.import_files.folder_text", lambda folder: folder.name)
    monkeypatch.setattr("fieldkit.paths.motor_folder", lambda: Path("/home/flyer/motors"))
    monkeypatch.setattr("fieldkit.paths.settings_file", lambda: Path("/home/flyer/settings.json"))
    monkeypatch.setattr("fieldkit.tui.next.desk.Desk.name", "/home/flyer/ledger.db")
    return tmp_path / "ledger.db"


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
@pytest.mark.parametrize("scene", SCENES)
async def test_a_page_looks_as_it_did_and_can_be_read(
    scene: str, size: tuple[int, int], file: Path, snapshot: SnapshotAssertion
) -> None:
    if scene == "log":
        with Ledger.open(file) as ledger:
            bring_in(ledger, [LOG], lambda name: None, defaults={"rocket": "Comet"})
    with patch("fieldkit.tui.screens.loop.look", lambda desk, rocket, on_progress: looked_at()):
        async with opened(file, size) as pilot:
            await press(pilot, *SCENES[scene])
            for theme in THEMES:
                pilot.app.theme = theme
                await calm(pilot)
                picture = pilot.app.export_screenshot(title="fieldkit")
                assert snapshot(name=theme, extension_class=SVGImageExtension) == picture
                if not (theme == "field" and scene in OVERLAID):
                    assert not list(unreadable(pilot, theme)), theme


async def test_the_palette_can_be_read_in_the_sun(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "T", "escape", "ctrl+p")
        assert "Search for commands" in shown(pilot)
        assert not list(unreadable(pilot, "sun"))


def unreadable(pilot: Pilot[None], theme: str) -> Iterator[str]:
    """Texts on the screen that lack contrast, or are dimmed."""
    if theme not in LEAST:
        return
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
    """By the relative luminance of two colours (WCAG 2.2, 1.4.3); letters of frames and blocks count as well."""
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


def test_the_suns_own_colours_have_a_contrast_of_seven() -> None:
    variables = SUN.to_color_system().generate()
    paper = TextualColor.parse(variables["background"])
    assert paper.rgb == (255, 255, 255)
    for name in ("foreground", "primary", "accent", "error", "success", "text-muted", "text-disabled", "border"):
        ink = TextualColor.parse(variables[name])
        assert ink.a == 1, name
        assert contrast(Color.from_rgb(*ink.rgb), Color.from_rgb(*paper.rgb)) >= 7, name


def test_the_contrast_of_black_on_white_is_21() -> None:
    assert contrast(Color.from_rgb(0, 0, 0), Color.from_rgb(255, 255, 255)) == pytest.approx(21)
    assert contrast(Color.from_rgb(119, 119, 119), Color.from_rgb(255, 255, 255)) == pytest.approx(4.48, abs=0.01)
