"""No command prints a figure that is not a number, or a warning of the arithmetic, whatever is planned or flown."""

import json
import math
import re
import warnings
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fieldkit.cli.main import main
from fieldkit.flight import MEASURED
from fieldkit.paths import REFERENCE_FLIGHTS

CHECK_SHAPES = False
NOT_FINITE = re.compile(r"(?<![a-zA-Z])(?:nan|inf|NaN|Infinity)(?![a-zA-Z])")


@pytest.fixture(scope="module")
def ledger(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("finite") / "ledger.db"
    assert main(["--ledger", str(file), "import", str(REFERENCE_FLIGHTS)]) == 0
    return file


def check(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """What a command prints, run with warnings as errors; it prints finite figures, or refuses in a line."""
    capsys.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        status = main(arguments)
    shown = capsys.readouterr()
    assert status in (0, 1), shown.err
    assert not NOT_FINITE.search(shown.out), shown.out
    assert not NOT_FINITE.search(shown.err), shown.err
    if status == 0 and "--json" in arguments:
        json.loads(shown.out, parse_constant=_refused)
    return shown.out


def _refused(constant: str) -> Any:
    raise AssertionError(f"found {constant} in JSON")


COMMANDS = {
    "predict": ["predict", "--motor", "F24-4W"],
    "predict --json": ["predict", "--motor", "F24-4W", "--json"],
    "predict --quick": ["predict", "--quick", "--motor", "A8-3"],
    "landing": ["landing", "--motor", "F24-4W"],
    "landing --json": ["landing", "--motor", "F24-4W", "--wind", "3", "--json"],
    "delay": ["delay", "--motor", "F24"],
    "ballast": ["ballast", "--motor", "F24-4W", "--target", "200m"],
    "motors --fit": ["motors", "--fit", "Astra"],
    "daysheet": ["daysheet", "--motor", "F24-4W", "--force", "--out"],
}
HEAVY = ("20kg", "1000kg", "3kg", "2.4kg")
"""A motor that does not lift, one far from it, and two near the edge."""


@pytest.mark.sampled
@pytest.mark.parametrize("mass", HEAVY)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_rocket_that_does_not_lift_gets_a_sentence_and_never_nan(
    name: str, mass: str, ledger: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.svg"
    target = [str(page)] if name == "daysheet" else []
    check(["--ledger", str(ledger), *COMMANDS[name], *target, "--dry-mass", mass], capsys)
    if page.exists():
        assert not re.search(r"\bnan\b", page.read_text(encoding="utf-8"))


@pytest.mark.sampled
@given(data=st.data())
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
def test_any_plan_gets_finite_figures_or_a_line(
    data: st.DataObject, ledger: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = data.draw(st.sampled_from([one for one in COMMANDS if one not in ("daysheet", "motors --fit")]))
    edges = {
        "--dry-mass": (0.1, 1e6, "g"),
        "--wind": (0, 60, "mps"),
        "--temperature": (-90, 70, "c"),
        "--pressure": (300, 1100, "hpa"),
        "--rail-length": (0.01, 100, "m"),
        "--rail-angle": (-90, 90, "deg"),
        "--site-elevation": (-500, 9000, "m"),
    }
    given_options = data.draw(st.lists(st.sampled_from(sorted(edges)), unique=True, max_size=4))
    options = []
    for option in given_options:
        low, high, unit = edges[option]
        value = data.draw(st.one_of(st.sampled_from([low, high]), st.floats(low, high)))
        options.append(f"{option}={value:.6g}{unit}")
    check(["--ledger", str(ledger), *COMMANDS[name], *options], capsys)


READOUTS = {
    "apogee_m": (0.1, 200_000),
    "top_speed_mps": (0.1, 3000),
    "burn_time_s": (0.01, 120),
    "peak_accel_g": (0.01, 1000),
    "avg_accel_g": (0, 1000),
    "coast_to_apogee_s": (0, 900),
    "descent_speed_mps": (0.1, 1000),
    "duration_s": (0.1, 86_400),
}


@pytest.mark.sampled
@given(data=st.data())
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
def test_any_ledger_gets_finite_figures_or_a_line(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path_factory.mktemp("any")
    columns = data.draw(st.lists(st.sampled_from(sorted(READOUTS)), unique=True, min_size=1, max_size=4))
    stated = data.draw(st.lists(st.sampled_from(columns), unique=True))
    names = [*columns, *map(sd_of, stated)]
    rows = []
    for number in range(data.draw(st.integers(1, 6))):
        cells = [f"{data.draw(st.one_of(st.sampled_from(READOUTS[c]), st.floats(*READOUTS[c]))):.6g}" for c in columns]
        cells += [f"{10 ** data.draw(st.floats(-8.9, 6)):.6g}" for _ in stated]
        mass = data.draw(st.sampled_from(["", "310", "0.1", "1000000"]))
        motor = data.draw(st.sampled_from(["F24-4W", "A8-3", "E35-5W"]))
        rows.append(",".join([str(number), "Astra", mass, motor, *cells]))
    table = folder / "table.csv"
    header = ",".join(["flight_id", "rocket", "dry_mass_g", "motor", *names])
    table.write_text("\n".join([header, *rows]) + "\n")
    ledger = ["--ledger", str(folder / "ledger.db")]
    check([*ledger, "import", str(table)], capsys)
    for command in (["flights"], ["infer"], ["predict", "--motor", "F24-4W", "--dry-mass", "310g", "--json"]):
        check([*ledger, *command], capsys)


def sd_of(column: str) -> str:
    """The column of a readout's standard deviation."""
    name, _, unit = column.rpartition("_")
    return f"{name}_sd_{unit}"


@pytest.mark.parametrize("sd", ["1e-300", "0", "1e300", "-1", "1e-10"])
def test_a_standard_deviation_beyond_its_limits_is_refused_by_row_and_column(
    sd: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "table.csv"
    table.write_text(f"flight_id,rocket,motor,dry_mass_g,apogee_m,apogee_sd_m\n1,Astra,F24-4W,310,250,{sd}\n")
    assert main(["--ledger", str(tmp_path / "l.db"), "import", str(table)]) == 0
    message = capsys.readouterr().err
    assert "row 2" in message
    assert "apogee_sd_m" in message
    assert re.search("expected a (standard deviation|plausible number)", message)


PLAUSIBLE = {
    "apogee": 250.0,
    "top_speed": 75.0,
    "burn_time": 2.1,
    "peak_accel": 14.0,
    "avg_accel": 4.0,
    "coast_to_apogee": 5.4,
    "apogee_to_eject": 0.4,
    "eject_altitude": 240.0,
    "descent_speed": 5.0,
    "duration": 55.0,
    "coast_drag": 1.6,
    "burn_impulse": 84.0,
}
"""A value of every readout, in its column's own unit."""
REPORT = "report.html"
EVERY_COMMAND = (
    ["flights"],
    ["show", "3"],
    ["infer"],
    ["predict", "--motor", "F24-4W"],
    ["predict", "--quick", "--motor", "F24-4W"],
    ["loop", "--details", "--dry-run", "--report", REPORT],
    ["loop", "--dry-run", "--json"],
    ["loop", "--quick", "--dry-run"],
    ["landing", "--motor", "F24-4W"],
    ["delay", "--motor", "F24"],
    ["ballast", "--motor", "F24-4W", "--target", "240m"],
    ["contest", "--target", "250m"],
    ["motors", "--fit", "Law"],
    ["compare", "1", "2"],
    ["score"],
    ["report", "2", "--out", REPORT],
    ["export"],
    ["export", "--format", "json"],
    ["history"],
)
ALSO_AS_JSON = ("flights", "show", "infer", "predict", "landing", "delay", "ballast", "contest", "compare", "score")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ledger of flights with every readout, with and without standard deviation and source."""
    folder = tmp_path_factory.mktemp("measured")
    assert PLAUSIBLE.keys() == {column.name for column in MEASURED}, "a new readout is tried here, too"
    headers = [part for column in MEASURED for part in (column.header, column.sd_header, column.source_header)]
    lines = [",".join(["flight_id", "rocket", "config", "dry_mass_g", "diameter_mm", "motor", "date_time", *headers])]
    for number in range(8):
        cells = []
        for column in MEASURED:
            value = PLAUSIBLE[column.name] * (1 + 0.02 * math.sin(7.0 * number + len(column.name)))
            annotated = [f"{0.03 * value:.3g}", "baro"] if number % 2 else ["", ""]
            cells += [f"{value:.4g}", *annotated]
        lines.append(",".join([str(number), "Law", "A", "322", "66", "F24-4W", f"2025-05-0{number + 1}T10:00", *cells]))
    table = folder / "table.csv"
    table.write_text("\n".join(lines) + "\n")
    assert main(["--ledger", str(folder / "ledger.db"), "import", str(table)]) == 0
    return folder / "ledger.db"


@pytest.mark.sampled
@pytest.mark.parametrize(
    "command",
    [*EVERY_COMMAND, *([*one, "--json"] for one in EVERY_COMMAND if one[0] in ALSO_AS_JSON)],
    ids=" ".join,
)
def test_every_command_knows_every_readout(
    command: list[str],
    measured: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    printed = check(
        ["--ledger", str(measured), *(str(tmp_path / one) if one == REPORT else one for one in command)], capsys
    )
    assert printed
    if "--details" in command:  # the table of fingerprints
        assert re.search(r" drag +impulse\n", printed)


@pytest.mark.parametrize("command", [["loop", "--details"], ["loop", "--quick"], ["infer"], ["score"]], ids=" ".join)
def test_apogees_too_uncertain_to_fit_are_no_flights_for_a_loop(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, ledger = tmp_path / "table.csv", ["--ledger", str(tmp_path / "l.db")]
    rows = "".join(f"{n},Law,F24-4W,322,250,1e6\n" for n in range(5))
    table.write_text(f"flight_id,rocket,motor,dry_mass_g,apogee_m,apogee_sd_m\n{rows}")
    assert main([*ledger, "import", str(table)]) == 0
    check([*ledger, *command, *(["--dry-run"] if "loop" in command else [])], capsys)
