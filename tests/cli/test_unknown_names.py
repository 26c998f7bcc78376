"""A command that is given a name it does not know reports that name first, with the nearest known one."""

import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from fieldkit.cli.main import app, main
from fieldkit.errors import nearest, unknown

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.fast
CHECK_SHAPES = False

TYPED = {
    "rocket": ("Astrra", "Astra"),
    "fit": ("Astrra", "Astra"),
    "shortlist_for": ("Astrra", "Astra"),
    "config": ("Ballats", "Ballast"),
    "site": ("Moorlnd", "Moorland"),
    "motor": ("F924-4W", "F"),
    "kit": ("Berta", "Bertha"),
    "device": ("mircopeak", "micropeak"),
    "format": ("perfectflit", "perfectflite"),
    "season": ("2040", "2027"),
    "effect": ("mas_offset", "mass_offset"),
    "decline": ("mas_offset", "mass_offset"),
    "tag": ("weak_lunch", "weak_launch"),
    "flight": ("13", "12"),
    "flights": ("13", "12"),
    "column": ("altitude=Altitud", "Altitude"),
    "map": ("altitude=Altitud", "Altitude"),
}
"""A misspelling for each parameter that takes a name, and the nearest known name."""
ON = "--motor F24-4W"
REST = {
    "ballast": f"{ON} --target 200m",
    "capture": "--rocket Astra",
    "compare": "{table} {table}",
    "contest": ON,
    "daysheet": f"{ON} --out {{folder}}/sheet.pdf",
    "delay": ON,
    "edit": "11 notes=calm",
    "finals": ON,
    "flyer": "--count 1",
    "inspect": "{table}",
    "import": "{table} --rocket Astra",
    "landing": ON,
    "motors": "F24",
    "predict": ON,
    "tag": "windy",
    "track": "--out {folder}/track.kml",
    "weather": "{table}",
    "untag": "windy",
    "add": f"{ON} --apogee 200m --rocket Astra --again",
}
"""The other arguments of a command, without which it would report something else."""
NEW = {("ork", "rocket"), ("ork", "config"), ("simulate", "motor"), ("capture", "flight")}
"""Parameters that name something new, or a flight in the memory of a logger; `simulate` has no ledger."""
OTHERWISE = {("predict", "flights"), ("daysheet", "flights"), ("export", "format")}
"""Parameters of these names that take a file, or one of the words in the help."""
FIT_ONLY = {"config", "site", "kit", "season"}
"""Options of `motors` that apply to the motors of a rocket."""


def named() -> Iterator[tuple[str, str, bool]]:
    """Each command with a parameter that takes a name, and whether it is an option."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    for name, command in group.commands.items():
        assert isinstance(command, TyperCommand | TyperGroup)
        for parameter in command.params:
            if parameter.name in TYPED and (name, parameter.name) not in NEW | OTHERWISE:
                yield name, parameter.name, parameter.param_type_name == "option"


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a ledger, a site, a kit, and a table of samples."""
    folder = tmp_path_factory.mktemp("filled")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FIELDKIT_LEDGER", str(folder / "ledger.db"))
        patch.setenv("FIELDKIT_HOME", str(folder))
        for line in (
            f"import {ROOT}/fieldkit/data/reference_flights.csv",
            "edit 12 config=Ballast tags=weak_launch",
            "sites Moorland --elevation 212m",
            "kits Bertha --dry-mass 80g --diameter 41.6mm",
        ):
            assert main(shlex.split(line)) == 0
    (folder / "table.csv").write_text("Time [s],Altitude [ft]\n" + "".join(f"{n / 10},{n}\n" for n in range(40)))
    return folder


@pytest.fixture
def ledger(filled: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """A copy of that folder, used by the commands."""
    shutil.copytree(filled, tmp_path, dirs_exist_ok=True)
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    monkeypatch.setattr("fieldkit.capture.ports", list)
    capsys.readouterr()
    return tmp_path


@pytest.mark.sampled
@pytest.mark.parametrize(("command", "name", "is_option"), list(named()))
def test_an_unknown_name_is_reported_first_with_the_nearest(
    command: str, name: str, is_option: bool, ledger: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    typed, expected = TYPED[name]
    rest = REST.get(command, "").format(folder=ledger, table=ledger / "table.csv")
    if command == "motors" and name in {*FIT_ONLY, "fit"}:
        rest = "--fit Astra"
    if is_option:
        given = shlex.split(rest)
        option = "--" + name.replace("_", "-")
        option = "--map" if name == "column" else option
        while option in given:
            at = given.index(option)
            del given[at : at + 2]
        arguments = [command, *given, option, typed]
    else:
        arguments = [command, typed, *shlex.split(rest)]
    main(arguments)
    first, *_ = capsys.readouterr().err.splitlines() or [""]
    assert typed.split("=")[-1] in first, arguments
    assert expected in first, arguments


def test_a_forecast_of_an_unknown_rocket_asks_for_no_mass(ledger: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["predict", "--motor", "F24-4W", "--rocket", "Nope"]) == 1
    assert capsys.readouterr().err.startswith("no rocket 'Nope', expected one of: Astra")


def test_names_are_listed_if_none_is_near() -> None:
    assert unknown("rocket", "Nope", ["Astra", "Comet"]) == "no rocket 'Nope', expected one of: Astra, Comet"
    assert unknown("rocket", "astrra", ["Astra", "Comet"]) == "no rocket 'astrra'; did you mean Astra?"
    assert unknown("kit", "Bertha", []) == "no kit 'Bertha' yet"


def test_the_most_similar_name_is_first_whatever_its_case() -> None:
    assert nearest("PERFECTFLIT", ["eggtimer", "perfectflite_table", "perfectflite"])[0] == "perfectflite"
