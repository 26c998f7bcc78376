"""A rocket that has never flown: mass and diameter suffice, a kit needs only its name, and recommended motors are safe
and sensible."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.planning.kits import kit_of
from fieldkit.planning.motor_guide import FIT_CHECKS
from fieldkit.rocket import Configuration
from fieldkit.services.day_weather import save_weather
from fieldkit.services.launch_day import first_forecast, planned
from fieldkit.services.pickers import names_of
from fieldkit.services.plans import completed_plan
from fieldkit.settings import Settings
from fieldkit.tui.home.first_run import read_first

CHECK_SHAPES = False

COMMANDS = [
    ["predict", "--motor", "F39T-6"],
    ["delay", "--motor", "F39T"],
    ["ballast", "--motor", "F39T-6", "--target", "800ft"],
    ["contest", "--season", "2027", "--motor", "F39T-6"],
    ["landing", "--motor", "F39T-6", "--wind", "3m/s"],
    ["finals", "--season", "2027", "--motor", "F39T-6", "--targets", "795-800"],
]


@pytest.mark.sampled
@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_mass_and_diameter_alone_make_a_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    body = ["--rocket", "Fresh", "--dry-mass", "400g", "--diameter", "66mm"]
    assert main([*ledger, *command, *body]) == 0
    out = " ".join(capsys.readouterr().out.split())
    if command[0] != "finals":
        assert "no flights of this rocket" in out
    if command[0] not in ("predict", "finals"):
        assert "one normal flight would narrow the apogee by" in out


def test_an_unknown_rocket_without_a_mass_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--ledger", str(tmp_path / "ledger.db"), "delay", "--motor", "F39T", "--rocket", "Fresh"]) == 1
    assert "Fresh" in capsys.readouterr().err


def test_a_kit_provides_mass_diameter_and_motor_mount(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "kits.toml").write_text('["Big Bertha"]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n')
    command = ["--ledger", str(tmp_path / "ledger.db"), "motors", "--fit", "Bertha", "--kit", "big bertha", "--json"]
    assert main([*command, "--class", "A-C"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["mount_mm"] == pytest.approx(18.0)
    assert document["conditions"] == {}
    with pytest.raises(BadValue, match="Big Bertha"):
        kit_of(tmp_path / "kits.toml", "Alpha")
    (tmp_path / "kits.toml").write_text('[Alpha]\ndry_mass_g = "light"\n')
    with pytest.raises(BadValue, match="Alpha, dry_mass_g"):
        kit_of(tmp_path / "kits.toml", "Alpha")


def test_a_kit_is_a_separate_rocket_and_takes_no_motor_wider_than_its_mount(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "kits.toml").write_text('["Big Bertha"]\ndry_mass_g = 80\ndiameter_mm = 41.6\nmount_mm = 18\n')
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(REFERENCE_FLIGHTS)]) == 0
    capsys.readouterr()
    kit = ["--kit", "big bertha", "--json"]
    assert main([*ledger, "predict", *kit, "--motor", "C6-5"]) == 0
    (made,) = json.loads(capsys.readouterr().out)["predictions"]
    assert (made["rocket"], made["flights"]) == ("Big Bertha", 0)
    assert main([*ledger, "delay", *kit, "--motor", "C6"]) == 0
    assert json.loads(capsys.readouterr().out)["rocket"] == "Big Bertha"
    for command in ("predict", "landing"):
        assert main([*ledger, command, *kit, "--motor", "F39T-6"]) == 1
        assert "24 mm wide, expected at most 18 mm" in capsys.readouterr().err


def test_the_app_uses_mass_and_diameter_of_the_kit_that_a_rocket_is_named_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    with pytest.raises(BadValue, match="a mass"):
        read_first(catalogue(), "dry_mass", "", "g")
    (tmp_path / "kits.toml").write_text('["Big Bertha"]\ndry_mass_g = 80\ndiameter_mm = 41.6\n')
    assert read_first(catalogue(), "dry_mass", "", "g") is None
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        plan = Flight(rocket="big bertha", motor="C6-5")
        made = first_forecast(ledger, catalogue(), Settings(), plan)
        assert (made.plan.dry_mass, made.plan.diameter) == pytest.approx((0.08, 0.0416))
        heavier = completed_plan(ledger, catalogue(), plan.with_changes(dry_mass=0.1), Settings())
        assert (heavier.dry_mass, heavier.diameter) == pytest.approx((0.1, 0.0416))


def test_a_guide_without_a_rail_or_a_ceiling_states_that_neither_was_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["--ledger", str(tmp_path / "ledger.db"), "motors", "--fit", "Fresh", "--dry-mass", "80g"]
    command += ["--diameter", "42mm", "--mount", "18mm", "--class", "C"]
    open_ones, field = {}, ["--field-size", "1000m", "--wind", "1m/s"]
    for name, more in (("open", []), ("given", [*field, "--rail-length", "1m", "--waiver", "300m"])):
        assert main([*command, *more, "--json"]) == 0
        motors = json.loads(capsys.readouterr().out)["motors"]
        open_ones[name] = {check for one in motors for check in one["not_judged"]} - {"ejection speed"}
    assert open_ones == {"open": {"rail exit speed", "ceiling", "field size"}, "given": set()}
    assert main(command) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "rail not given: 1.0 m assumed for the speed off it" in text
    assert "field not given" in text
    assert "excluded by its height" in text


def test_the_same_motors_are_listed_once_and_what_only_the_flyer_can_check_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A G motor is too heavy and has too much impulse for a contest: it was listed under either."""
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    body = ["--dry-mass", "540g", "--diameter", "66mm", "--mount", "24mm", "--season", "2027"]
    assert main(["--ledger", str(tmp_path / "ledger.db"), "motors", "--fit", "Fresh", *body, "--class", "F-G"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "excluded by contest mass, contest impulse, contest motor class: " in text
    assert text.count("144G65-8A") == 1
    missing, by_eye = text.split("? not checked, inputs missing: ")[1].split("? check yourself, where they apply: ")
    assert "motor temperature" in missing
    assert "sky" not in missing
    assert "recovery places, sky, recovery" in by_eye


def test_motors_that_fit_are_safe_and_sensible_and_the_others_have_a_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    body = ["--dry-mass", "400g", "--diameter", "66mm", "--mount", "29mm", "--class", "F-G", "--waiver", "600m"]
    assert main([*ledger, "motors", "--fit", "Fresh", *body, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["motors"]
    for one in found:
        unsafe = {line["check"] for line in one["safety"] if line["verdict"] == "unsafe"} & set(FIT_CHECKS)
        assert one["fits"] is (not unsafe)
        assert set(one["why_not"]) == unsafe
    assert any(one["why_not"] == ["ceiling"] for one in found)
    assert any(one["fits"] for one in found)
    assert main([*ledger, "motors", "--fit", "Fresh", *body]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "excluded by ceiling" in text
    that_fit = [one for one in found if one["fits"]]
    for check in {line["check"] for one in that_fit for line in one["safety"] if line["verdict"] == "caution"}:
        lines = re.findall(rf"! (?:[a-z ]+, )*{check}(?:, [a-z ]+)*: caution: ", text)
        assert len(lines) == 1, "one line per check, however many motors it concerns"
    weak = [one["motor"] for one in that_fit if verdict_of(one, "thrust to weight") == "caution"]
    assert f"! thrust to weight: caution: {', '.join(weak)} " in text


def verdict_of(choice: dict[str, Any], check: str) -> str:
    return str(next(line["verdict"] for line in choice["safety"] if line["check"] == check))


def test_a_rocket_of_unknown_mount_takes_every_motor_no_wider_than_its_body(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [
        "--ledger",
        str(tmp_path / "ledger.db"),
        "motors",
        "--fit",
        "Fresh",
        "--dry-mass",
        "80g",
        "--class",
        "B-D",
    ]
    assert main([*command, "--diameter", "25mm", "--json"]) == 0
    found = {one["motor"] for one in json.loads(capsys.readouterr().out)["motors"]}
    assert {"C6", "D12"} <= found
    assert main([*command, "--diameter", "20mm"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "motors of up to 20 mm" in out
    assert "mount not given" in out
    assert "D12" not in out
    assert main(["Bare" if one == "Fresh" else one for one in command]) == 1
    assert "no diameter, expected --mount" in capsys.readouterr().err


def test_a_stable_rocket_turns_into_the_wind_sooner_and_lands_nearer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = ["landing", "--motor", "F39T-6", "--wind", "5m/s", "--dry-mass", "400g", "--diameter", "66mm"]
    command = ["--ledger", str(tmp_path / "ledger.db"), *plan, "--rocket", "Fresh", "--json"]
    away = []
    for margin in ("1", "5"):
        assert main([*command, "--stability-cal", margin]) == 0
        away.append(json.loads(capsys.readouterr().out)["landing"]["away_m"]["p50"])
    assert away[1] < away[0]
    assert main([*command, "--stability-cal", "stable"]) == 1
    assert "body diameters above zero" in capsys.readouterr().err


def test_a_plan_without_a_configuration_does_not_take_that_of_another_rocket(tmp_path: Path) -> None:
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        ledger.add([Flight("1", "Astra", "A", "F24-4W", dry_mass=0.32, diameter=0.066, apogee=250.0)])
        save_weather(ledger, Flight(wind=3.0))
        first_forecast(ledger, catalogue(), Settings(), Flight(rocket="Comet", motor="C6-5", dry_mass=0.1))
        plan = planned(ledger, ledger.flights())
        assert plan is not None
        assert (plan.rocket, plan.config, plan.wind) == ("Comet", "", 3.0)


def test_every_name_in_the_guide_identifies_its_motor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Manufacturers share names such as C6; only one of these fits this rocket, and it is not the one found as `C6`."""
    command = ["--ledger", str(tmp_path / "ledger.db"), "motors", "--fit", "Fresh", "--dry-mass", "65g"]
    command += ["--diameter", "42mm", "--mount", "18mm", "--rail-length", "3ft"]
    assert main([*command, "--json"]) == 0
    that_fit = {(one["maker"], one["motor"]) for one in json.loads(capsys.readouterr().out)["motors"] if one["fits"]}
    assert main(command) == 0
    rows = re.findall(r"^(\S.*?) \*? +\d+ +\d+-\d+ ", capsys.readouterr().out, re.MULTILINE)
    read = (catalogue().resolve(name.strip(" *")).motor for name in rows)
    assert {(motor.maker, motor.designation) for motor in read} == that_fit
    assert ("Quest", "C6") in that_fit


@pytest.mark.thorough
def test_a_plan_reports_values_that_look_mistyped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(REFERENCE_FLIGHTS)]) == 0
    assert main([*ledger, "sites", "Moor", "--field-size", "100m"]) == 0
    capsys.readouterr()

    def plan(command: str, *options: str, status: int = 0) -> tuple[str, str]:
        assert main([*ledger, command, "--motor", "F24-4W", "--wind", "3m/s", *options]) == status
        out, err = capsys.readouterr()
        return out, err

    body = ["--dry-mass", "400g", "--diameter", "66mm"]
    out, err = plan("landing", "--rocket", "astra", "--site", "moor")
    assert out.startswith("Astra")
    assert "this field is 100 m" in out
    assert not err
    _, err = plan("landing", "--rocket", "Asrta", "--site", "Mooor", *body)
    assert "did you mean Astra?" in err
    assert "did you mean Moor?" in err
    # a delay takes the options of a landing and a sixth of its time
    assert "did you mean Astra?" in plan("delay", "--rocket", "Astar", *body)[1]
    assert "did you mean Moor?" in plan("delay", "--rocket", "Astra", "--site", "Mooor")[1]
    assert "dry mass 0.4 g is unusual" in plan("delay", "--rocket", "Astra", "--dry-mass", "0.4")[1]
    assert (
        "found a motor of 24 mm in a body of 6.6 mm"
        in plan("delay", "--rocket", "Astra", "--diameter", "6.6", status=1)[1]
    )
    (note,) = plan("delay", "--rocket", "Zephyr", "--site", "Fen", *body)[1].splitlines()
    assert note.startswith("note: saved dry mass 400 g")


def test_a_motor_that_needs_a_larger_field_does_not_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["--ledger", str(tmp_path / "ledger.db"), "motors", "--fit", "Fresh", "--dry-mass", "40g"]
    command += ["--diameter", "25mm", "--mount", "18mm", "--class", "B-C", "--field-size", "300ft", "--json"]
    assert main(command) == 0
    found = json.loads(capsys.readouterr().out)["motors"]
    too_small = {one["motor"][0]: "field size" in one["why_not"] for one in found}
    assert too_small == {"B": False, "C": True}  # 200 and 400 ft by the safety code
    assert not any(one["fits"] for one in found if one["motor"].startswith("C"))


def test_a_design_is_the_rocket_to_plan_and_is_offered_until_something_has_flown(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert planned(ledger, []) is None
        ledger.keep_design(Configuration("Level Two", "", dry_mass=3.1, diameter=0.098, cd=0.52))
        plan = planned(ledger, [])
        assert plan is not None
        assert plan.rocket == "Level Two"
        names = names_of(ledger, catalogue())
        assert [(one.text, one.about) for one in names.sources()["rocket"]("lev")] == [("Level Two", "design")]
        assert names.doubt("rocket", "Level") == "No rocket Level yet; did you mean Level Two?"
        ledger.add([Flight(flight_id="1", rocket="Lark", motor="F24-4W", dry_mass=0.322, apogee=281.3)])
        plan = planned(ledger, ledger.flights())
        assert plan is not None
        assert plan.rocket == "Lark"


@pytest.mark.parametrize(
    ("given", "assumed"), [((), True), (("--main-speed", "5m/s"), False), (("--parachute-diameter", "450mm"), False)]
)
def test_the_table_of_finals_has_no_parachute_for_an_assumed_descent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], given: tuple[str, ...], assumed: bool
) -> None:
    plan = ["finals", "--season", "2027", "--motor", "F39T-6", "--dry-mass", "480g", "--diameter", "66mm"]
    assert main(["--ledger", str(tmp_path / "ledger.db"), *plan, *given]) == 0
    out = capsys.readouterr().out
    assert ("no parachute is advised" in out) == assumed
    (headers,) = [line for line in out.splitlines() if line.startswith("target ft")]
    assert ("parachute" not in headers) == assumed


@pytest.mark.parametrize(
    ("command", "answer"),
    [("landing", "  landing "), ("delay", "  best "), ("predict", "Lark on"), ("ballast", "mean miss")],
)
def test_the_answer_is_on_the_last_screen_of_a_small_terminal_with_every_failed_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, answer: str
) -> None:
    """Of 24 rows, one is for the prompt; about forty lines of checks once scrolled it away."""
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    options = ["--rocket", "Lark", "--motor", "F39T-6", "--dry-mass", "480g", "--diameter", "66mm", "--wind", "12m/s"]
    options += ["--target", "800ft"] if command == "ballast" else []
    assert main([*ledger, command, *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(answer in line for line in lines[-23:])
    marks = [line.split()[0] for line in lines if line.startswith("    ") and line.split()[0] in "✓?!⊘"]
    assert marks == sorted(marks, key="⊘!?✓".index)
    assert set(marks) >= {"⊘", "?"}


def test_a_plan_without_a_mass_or_flights_says_what_it_needs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = ["landing", "--motor", "F39T-6", "--rocket", "Fresh"]
    assert main(["--ledger", str(tmp_path / "ledger.db"), *plan]) == 1
    assert "a rocket that has not flown needs --dry-mass and --diameter" in capsys.readouterr().err
