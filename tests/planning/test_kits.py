"""The flyer's kits are saved, changed, and deleted without touching what else is in their file."""

import json
import tomllib
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.planning.kit_file import drop_kit, put_kit
from fieldkit.planning.kits import KIT_KEYS, Kit, read_kits
from fieldkit.services.forecasts import rocket_of
from fieldkit.services.pickers import names_of

WRITTEN = """# kits of the club

["Big Bertha"]  # blue
dry_mass_g = 80
diameter_mm = 41.6
owner = "Ann"

[Alpha]
dry_mass_g = 30
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "kits.toml").write_text(WRITTEN)
    return tmp_path / "kits.toml"


def test_a_change_keeps_comments_other_keys_and_other_kits(file: Path) -> None:
    put_kit(file, Kit("Big Bertha", 12.5, 0.0416, 0.018), "big bertha")
    text = file.read_text(encoding="utf-8")
    assert "# kits of the club" in text
    assert 'owner = "Ann"' in text
    kits = read_kits(file)
    assert kits["big bertha"].figures == pytest.approx((12.5, 0.0416, 0.018))
    assert kits["alpha"] == Kit("Alpha", 0.03, None, None)


def test_a_kit_is_renamed_added_and_deleted(file: Path) -> None:
    put_kit(file, Kit('The "B"', 0.08, None, None), "Big Bertha")
    put_kit(file, Kit("Wren", None, 0.025, None))
    assert [kit.name for kit in read_kits(file).values()] == ['The "B"', "Alpha", "Wren"]
    put_kit(file, Kit("alpha", 0.03, None, None), "Alpha")
    drop_kit(file, 'THE "b"')
    assert [kit.name for kit in read_kits(file).values()] == ["alpha", "Wren"]


@pytest.mark.parametrize(
    ("kit", "was", "message"),
    [
        (Kit("Alpha", 0.1, None, None), "", "another kit 'Alpha'"),
        (Kit("alpha", 0.1, None, None), "Big Bertha", "another kit 'Alpha'"),
        (Kit(" ", 0.1, None, None), "", "expected a name"),
        (Kit("a\nb", 0.1, None, None), "", "expected a name"),
        (Kit("New", -0.1, None, None), "", "New, dry mass: found -100 g"),
        (Kit("New", float("nan"), None, None), "", "found nan"),
    ],
)
def test_an_invalid_kit_is_refused_and_nothing_changes(file: Path, kit: Kit, was: str, message: str) -> None:
    with pytest.raises(BadValue, match=message):
        put_kit(file, kit, was)
    assert file.read_text(encoding="utf-8") == WRITTEN


def test_a_file_in_another_style_is_left_to_the_user(file: Path) -> None:
    other = "Alpha = { dry_mass_g = 30 }\n"
    file.write_text(other, encoding="utf-8")
    with pytest.raises(BadValue, match="expected a change by hand"):
        put_kit(file, Kit("Alpha", 0.031, None, None), "Alpha")
    with pytest.raises(BadValue, match="expected a change by hand"):
        drop_kit(file, "Alpha")
    assert file.read_text(encoding="utf-8") == other


def test_the_command_lists_saves_and_deletes_kits(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kits", "alpha", "--mount", "13mm", "--json"]) == 0
    (alpha,) = json.loads(capsys.readouterr().out)["kits"]
    assert alpha == {"kit": "Alpha", "dry_mass_g": 30.0, "diameter_mm": None, "mount_mm": 13.0}
    assert main(["kits", "Big Bertha", "--delete"]) == 0
    assert "Alpha" in (capsys.readouterr(), main(["kits"]), capsys.readouterr())[2].out
    assert main(["kits", "Big Bertha"]) == 1
    assert "expected one of: Alpha" in capsys.readouterr().err
    assert main(["kits", "--mount", "13mm"]) == 2


def test_a_rocket_named_after_a_kit_is_offered_and_has_its_motor_mount(file: Path, tmp_path: Path) -> None:
    put_kit(file, Kit("Big Bertha", 0.08, 0.0416, 0.018), "Big Bertha")
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        names = names_of(ledger, catalogue())
        assert [(one.text, one.about) for one in names.sources()["rocket"]("ber")] == [("Big Bertha", "kit")]
        assert not names.doubt("rocket", "Big Bertha")
        assert rocket_of(ledger, catalogue(), "Big Bertha").mount == pytest.approx(0.018)


UNEVEN = {
    "brackets in a text": '[a]\nnote = """\n[b]\ndry_mass_g = 9\n"""\ndry_mass_g = 3\n',
    "brackets in a list": "[a]\nlist = [\n[1],\n[2]]\n",
    "a table in a kit": "[a]\ndry_mass_g = 3\n[a.sub]\ndry_mass_g = 5\n",
    "a key in quotes": '[a]\n"dry_mass_g" = 3\n',
    "a kit in a line": "a = {dry_mass_g = 3}\n",
}


@pytest.mark.parametrize("what", UNEVEN)
def test_a_file_that_cannot_be_changed_line_by_line_is_not_changed(what: str, tmp_path: Path) -> None:
    """Neither a broken file nor wrong figures may result, and nothing else in it may be lost."""
    file = tmp_path / "kits.toml"
    for change in (
        lambda: drop_kit(file, "a"),
        lambda: put_kit(file, Kit("a", 0.08, None, None), "a"),
        lambda: put_kit(file, Kit("c", None, 0.05, None), "a"),
    ):
        file.write_text(UNEVEN[what], encoding="utf-8")
        before = tomllib.loads(UNEVEN[what])["a"]
        try:
            change()
        except BadValue:
            assert file.read_text(encoding="utf-8") == UNEVEN[what]
            continue
        after = tomllib.loads(file.read_text(encoding="utf-8"))
        kept = {key: value for key, value in before.items() if key not in KIT_KEYS}
        assert after in ({}, {"a": {**kept, "dry_mass_g": 80.0}}, {"c": {**kept, "diameter_mm": 50.0}})


def test_a_file_that_is_too_large_is_named_with_its_limit(tmp_path: Path) -> None:
    """Its limit is below a megabyte, which was printed as 0, after the number of the error."""
    file = tmp_path / "kits.toml"
    file.write_text("# kit\n" * 500_000)
    with pytest.raises(BadValue, match=r"kits.toml: found more than [1-9]\d* KiB, expected TOML"):
        read_kits(file)
