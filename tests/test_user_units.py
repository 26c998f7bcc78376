"""Numbers are shown in the units that the user chose, and in no others."""

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from typer.main import get_command

from fieldkit.cli.main import app, main
from tests.user_units import foreign_figures
from tools.strings import texts

CHECK_SHAPES = False
ROOT = Path(__file__).parents[1]

LINES = """
inspect sample_logs/perfectflite__drogue_and_main.pf2
import fieldkit/data/reference_flights.csv
import sample_logs/perfectflite__drogue_and_main.pf2 --set rocket=Comet --set motor=F24-4W --set dry_mass=11oz
add --rocket Astra --config A --motor F24-4W --dry-mass 11.4oz --diameter 2.6in --apogee 935ft --wind 5mph
add --rocket Heavy --motor F24-4W --dry-mass 700lb --diameter 2.6in --apogee 935ft
add --rocket High --motor F24-4W --dry-mass 11.4oz --diameter 2.6in --apogee 9350ft --top-speed 9mph
flights
show Astra/1
show flight-dd2afbb08f
edit Astra/2 apogee=922ft
history
infer
predict --rocket Astra --config A --motor F24-4W --wind 8mph --temperature 95F --site-elevation 4500ft --rules NAR,FAA
motors F24
motors --fit Astra --target 800ft --class F
delay --rocket Astra --motor F24-4W
ballast --rocket Astra --motor F24-4W --target 800ft
contest --rocket Astra --season 2026 --motor F24-4W
finals --rocket Astra --season 2027 --motor F39T-6 --temperature 77F --wind 7mph
landing --rocket Astra --motor F24-4W --wind 9mph --wind-aloft 20mph --field-size 1300ft
simulate --motor F24-4W --dry-mass 11.4oz --diameter 2.6in --cd 0.6 --wind 11mph
loop --rocket Astra --quick
model --rocket Astra
score --rocket Astra
compare flight-dd2afbb08f sample_logs/perfectflite__drogue_and_main.pf2
kits Bertha --dry-mass 2.8oz --diameter 1.64in --mount 18mm
kits
sites Meadow --elevation 700ft --size 1300ft --ceiling 3000ft
sites
predict --rocket Astra --motor F24-4W --site Meadow
predict --rocket Fresh --lift-off-mass 14oz --diameter 2.6in --motor F39-6T --rail-length 6ft --stability-cal 1.5
predict --rocket Astra --motor F24-4W --main-altitude 500ft --drogue-speed 60mph --main-speed 12mph --wind 9mph
flyer --certification 1 --born 2009-05-31 --rails 3ft,6ft
motors --about
simulate --motor D12-0/C6-0/C6-7 --booster-mass 2oz/1.5oz --dry-mass 3.5oz --diameter 1.2in --cd 0.6
add --rocket Astra --motor F24-4W --apogee 879ft --date-time 2026-05-16T14:30 --site Moor --site-elevation 1440ft
weather docs/example-weather.csv --site Moor
show 13
remeasure --dry-run
units
paper
history
mappings
predictions
"""
"""A session of a user with US customary units; nothing is typed in metric ones."""


@pytest.fixture
def us_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user with US customary units and an empty ledger, in the checkout."""
    (tmp_path / "settings.json").write_text(json.dumps({"units": "US"}), encoding="utf-8")
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.chdir(ROOT)


@pytest.mark.thorough
@pytest.mark.usefixtures("us_home")
def test_commands_show_no_metric_figures_to_a_user_of_us_units(capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for line in LINES.strip().splitlines():
        assert main(shlex.split(line)) == 0, line
        shown = capsys.readouterr()
        found += [f"{line}: {figure}" for figure in foreign_figures(shown.out + shown.err, "US")]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("text", "system", "found"),
    [
        ("apogee    281.3 m", "US", True),
        ("apogee    923 ft", "US", False),
        ("apogee    923 ft", "SI", True),
        ("dry mass 322 g, 2.5 mm", "US", True),
        ("Peak acceleration 7.7 g", "US", False),
        ("8 motors of 24 mm fit", "US", False),
        ("MAE [m]", "US", True),
        ("stated_apogee_m   161.544", "US", True),
        ("9.4 in the first half second", "SI", False),
        ("47 N s, 30 m/s", "US", True),
        ("±0.0765 lb/ft³", "SI", True),
    ],
)
def test_figures_of_the_other_system_are_found(text: str, system: str, found: bool) -> None:
    assert bool(foreign_figures(text, system)) == found


def _helps() -> Iterator[tuple[str, str]]:
    """Each command's options with their help."""
    group = get_command(app)
    assert isinstance(group, click.Group) or hasattr(group, "commands")
    for name, command in group.commands.items():
        for option in command.params:
            yield f"{name} {option.name}", getattr(option, "help", None) or ""


METRIC = re.compile(r"(?<![\w.])\d[\d.]*(?:m|m/s|g|kg|mm)(?![\w/])")
CUSTOMARY = re.compile(r"(?<![\w.])\d[\d.]*(?:ft|mph|oz|in|lb)(?![\w/])|\b(?:in|or) (?:g|mm|m|m/s|°C|hPa)\b")


def test_the_help_of_an_option_shows_a_typed_unit_of_each_system() -> None:
    """Diameters of motors are in millimeters everywhere; tolerances have a default instead of an example."""
    motors = {"motors search", "motors mount"}
    found = [f"{name}: {text}" for name, text in _helps() if METRIC.search(text) and not CUSTOMARY.search(text)]
    assert [one for one in found if one.split(":")[0] not in motors] == []
    bare = [f"{name}: {text}" for name, text in _helps() if re.search(r"; in (g|mm|m|m/s|°C|hPa)\.", text)]
    assert [one for one in bare if "_accel:" not in one] == []
    assert any(METRIC.search(text) and CUSTOMARY.search(text) for _, text in _helps())


def test_no_text_has_a_metric_unit_beside_a_value_that_is_not_an_amount() -> None:
    """An amount brings its unit; errors about a cell of a file have the unit of its column."""
    own = {"fieldkit/messages.py", "fieldkit/importing/tables/column_units.py", "parsers/weather/winds_aloft.py"}
    metric = re.compile(r"\{[^}]*\} (m|m/s|km|kg|°C|hPa)(?![\w/²³^])")
    folders = ("fieldkit/analysis", "fieldkit/importing", "fieldkit/planning", "fieldkit/presentation", "parsers")
    found = {f"{file}:{line}: {text}" for file, line, text in texts(folders) if file not in own and metric.search(text)}
    assert found == set()
