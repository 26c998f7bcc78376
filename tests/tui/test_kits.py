"""Kits in the app: listed, added, changed, deleted, and offered as rockets, using only keys."""

from pathlib import Path

import pytest

from fieldkit.planning.kits import kit_of, read_kits
from fieldkit.tui.setup.setup_card import SetupCard
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.table import Table
from tests.pressing import at_home, opened, press, text_of, typed, words

CHECK_SHAPES = False
TO_KITS = ("6", "left", "left")


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


async def test_a_kit_is_added_changed_and_deleted(file: Path) -> None:
    own = file.parent / "home" / "kits.toml"
    async with opened(file) as pilot:
        await press(pilot, *TO_KITS)
        assert "No kits yet" in words(pilot)
        assert "Remove" not in text_of(pilot, "KeyBar"), "no kit to remove or to open"
        assert "Enter" not in text_of(pilot, "KeyBar")
        await press(pilot, "i", *typed("Big Bertha"), "down", *typed("80g"), "down", *typed("41.6mm"), "enter")
        await press(pilot, *typed("18"), "ctrl+s")
        assert "Saved the kit Big Bertha" in words(pilot)
        assert "Enter Edit kit" in words(pilot)
        assert "x Remove" in words(pilot)
        assert "motors up to 18 mm" in words(pilot)
        await press(pilot, "enter", "down", "ctrl+u", *typed("oops"), "ctrl+s")
        assert "✗ found 'oops'" in words(pilot)
        await press(pilot, "ctrl+u", *typed("85g"), "ctrl+s")
        assert "85 g" in words(pilot)
        kit = kit_of(own, "big bertha")
        assert (kit.dry_mass, kit.diameter, kit.mount) == pytest.approx((0.085, 0.0416, 0.018))
        await press(pilot, "x", "n")
        assert len(read_kits(own)) == 1
        await press(pilot, "x", "y")
        assert "No kits yet" in words(pilot)
    assert read_kits(own) == {}


@pytest.mark.thorough
async def test_a_plan_and_a_flight_use_the_figures_of_the_picked_kit(file: Path) -> None:
    own = file.parent / "home" / "kits.toml"
    own.parent.mkdir(exist_ok=True)
    own.write_text('["Big Bertha"]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n')
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "p", "down", "down", *typed("400g"), "ctrl+s")
        assert "400 g dry" in words(pilot)
        await press(pilot, "p", "ctrl+u", *typed("big"), "_")
        assert "Big Bertha kit" in words(pilot)
        await press(pilot, "down", "enter", "ctrl+s")
        assert "80 g dry" in words(pilot)
        await press(pilot, "slash", *typed("f39t"), "enter", "_")
        assert "and the mount of the kit has 18 mm" in text_of(pilot, "#more")


async def test_a_damaged_file_of_kits_gives_a_notice_and_the_other_lists_are_shown(file: Path) -> None:
    own = file.parent / "home" / "kits.toml"
    own.parent.mkdir(exist_ok=True)
    own.write_text("[Alpha\n")
    async with opened(file, page="setup") as pilot:
        await press(pilot, "right")
        assert "kits.toml" in words(pilot)
        assert "Astra" in words(pilot)


async def test_a_kit_shows_the_motors_that_fit_it_and_the_rockets_named_after_it(file: Path) -> None:
    own = file.parent / "home" / "kits.toml"
    own.parent.mkdir(exist_ok=True)
    own.write_text("[astra]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n")
    async with opened(file, (160, 50)) as pilot:
        await press(pilot, *TO_KITS)
        assert "Rockets named after it" in words(pilot)
        assert "Astra B " in words(pilot)
        assert "B B2 !, B4 !, B6, B6W !, B14T" in words(pilot)
        assert "! thrust to weight below 5" in words(pilot)


async def test_each_list_of_setup_is_searched_by_its_own_words(file: Path) -> None:
    own = file.parent / "home" / "kits.toml"
    own.parent.mkdir(exist_ok=True)
    own.write_text('["Big Bertha"]\nmount_mm = 18\n[Alpha]\nmount_mm = 13\n')
    async with opened(file, page="setup") as pilot:
        await press(pilot, "left", "left", "slash", *typed("bertha"), "enter")
        assert "Big Bertha" in words(pilot)
        assert "Alpha" not in words(pilot)
        assert "x Remove" in words(pilot)
        await press(pilot, "slash", *typed("zz"), "enter")
        assert "no row has all of these words; / changes them" in words(pilot)
        assert "Remove" not in text_of(pilot, "KeyBar")
        await press(pilot, "left", "left", "slash", *typed(" b"), "enter")
        assert "Astra B" in words(pilot)
        assert "Astra A" not in words(pilot)
        await press(pilot, "right", "right", "slash", "ctrl+u", "enter")
        assert "Alpha" in words(pilot)
        await press(pilot, "right")
        assert "Find" not in text_of(pilot, "KeyBar"), "settings are too few to search"
        await press(pilot, "slash")
        assert "theme" in words(pilot)


async def test_a_short_list_leaves_its_room_to_the_card_with_its_picture_beside_the_facts(file: Path) -> None:
    own = file.parent / "home" / "kits.toml"
    own.parent.mkdir(exist_ok=True)
    own.write_text("[astra]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n")
    async with opened(file, (160, 50)) as pilot:
        for keys in (TO_KITS, ("left",)):  # kits, sites
            await press(pilot, *keys, "_")
            screen = pilot.app.screen
            table, card = screen.query_one(Table).region, screen.query_one(SetupCard).region
            plot = screen.query_one(Plot)
            assert table.width == card.width == 160
            assert table.height < 8 < 30 < card.height
            assert plot.region.x > 75
            assert plot.region.height > 30
        await press(pilot, "left", "left")
        assert screen.query_one(Table).region.height > 30, "the catalog is long"
