"""The motor catalog: its contents, and how a written name finds its motor."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.errors import AmbiguousMotor, FieldkitError, UnknownMotor
from fieldkit.importing.manual_entry import read_answer
from fieldkit.motors import PLUGGED_DELAY, Catalogue, Motor, catalogue, describe, is_cluster, own
from fieldkit.motors.motor import impulse
from fieldkit.motors.names import in_capitals
from fieldkit.planning.delay import drill_of, offered
from tests.commands import Run
from tests.effort import examples

LAUNCHES = Path(__file__).parents[3] / "shared" / "logs" / "altimetertwo__rocketlaunchjournal_launches.csv"

UNMISTAKABLE = {
    "F24-4W": ("AeroTech F24W", 4),
    "F24W-4": ("AeroTech F24W", 4),
    "F24": ("AeroTech F24W", None),
    "AeroTech F24": ("AeroTech F24W", None),
    "F24W AeroTech": ("AeroTech F24W", None),
    "aerotech f24-4": ("AeroTech F24W", 4),
    " F24–4W ": ("AeroTech F24W", 4),
    "F24W-4s": ("AeroTech F24W", 4),
    "RMS-24/40 F24W": ("AeroTech F24W", None),
    "1 F24-7": ("AeroTech F24W", 7),
    "h219t": ("AeroTech H219T", None),
    "F39": ("AeroTech F39T", None),
    "F39T-6": ("AeroTech F39T", 6),
    "AeroTech F39T-6": ("AeroTech F39T", 6),
    "E35-5W": ("Quest E35W", 5),
    "E35W": ("Quest E35W", None),
    "1/2A3-2T": ("Estes 1/2A3", 2),
    "½A3-2": ("Estes 1/2A3", 2),
    "1/2 A3-2T": ("Estes 1/2A3", 2),
    "A10-PT": ("Estes A10", PLUGGED_DELAY),
    "A10-3T": ("Estes A10", 3),
    "D12-3": ("Estes D12", 3),
    "H128W-14A": ("AeroTech H128W", 14),
    "I205W": ("AeroTech HP-I205W", None),
    "HP-I205W-10": ("AeroTech HP-I205W", 10),
    "L1390G-P": ("AeroTech L1390G", PLUGGED_DELAY),
    "M1297W-P": ("AeroTech M1297W", PLUGGED_DELAY),
    "AT H123": ("AeroTech H123W", None),
    "Pro38 H123": ("Cesaroni 232H123-14A", None),
    "29mm H123": ("Cesaroni 176H123-12A", None),
    "D9-4": ("AeroTech D9W", 4),
    "G64-10": ("AeroTech G64W", 10),
    "CTI H118": ("Cesaroni 216H118-12A", None),
    "216H118-12A": ("Cesaroni 216H118-12A", 12),
    "WW-38-390": ("AMW WW-38-390", None),
    "micro maxx ii": ("Quest MICRO_MAXX_II", None),
    "F20-7": ("AeroTech F20W/L", 7),
    "Estes C6-5": ("Estes C6", 5),
    "29/120 G64W-7": ("AeroTech G64W", 7),
    "RMS 29/40-120 G64W": ("AeroTech G64W", None),
    "F39T-6 RMS 24/40": ("AeroTech F39T", 6),
    "Loki 38/240 H144": ("Loki H144-LW", None),
    "DMS G80T-14A": ("AeroTech G80T", 14),
    "AeroTech Econojet F20-4W": ("AeroTech F20W/L", 4),
    "Estes PSII E30-4": ("Estes E30", 4),
    "P54-4G K940": ("Cesaroni 1633K940-18A", None),
    "Pro 38 I205": ("Cesaroni I205", None),
    "1633-K940-WT-18A": ("Cesaroni 1633K940-18A", 18),
    "H242-M": ("AeroTech H242T", None),
    "H128W-M": ("AeroTech H128W", None),
    "G80NBT-10": ("AeroTech G80T", 10),
    "G76 Mojave Green-10": ("AeroTech G76G", 10),
    "F36-9A SS": ("Cesaroni 41F36-11A", 9),
    "F36-BS": ("Cesaroni 51F36-14A", None),
    "I285 Classic": ("Cesaroni 512I285-15A", None),
    "I285R": ("AeroTech I285R", None),
    "C6-5 (Estes)": ("Estes C6", 5),
    "F 24-4W": ("AeroTech F24W", 4),
    "F24-4W*": ("AeroTech F24W", 4),
    "F51-6T": ("AeroTech F51NT", 6),
    "F51NT-6": ("AeroTech F51NT", 6),
    "F42-8T": ("AeroTech F42T/L", 8),
    "I284W (AT)": ("AeroTech I284W", None),
    "J450ST (AMW)": ("AMW ST-54-1050", None),
    "K1075GG (AMW)": ("AMW GG-54-2550", None),
    "L1080BB (AMW)": ("AMW BB-75-3500", None),
    "I205 (CTI)": ("Cesaroni I205", None),
    "N2700W": ("AeroTech N2700W-PS", None),
    "G77-7R": ("AeroTech G77R/L", 7),  # of two with an R, the one sold under this name
    "G77-8R": ("AeroTech G77R", 8),
    "HyperTEK 2800CC172L-L540-P": ("Hypertek 2800CC172L-L540", None),
}

LIKELY = {
    "C6-5": ("Estes C6", 5),
    "A8-3": ("Estes A8", 3),
    "A3-4T": ("Estes A3", 4),
    "38mm H123": ("AeroTech H123W", None),
    "F52-5": ("AeroTech F52T", 5),
    "G75-6": ("AeroTech G75J", 6),
    "G75-11": ("AeroTech G75M", 11),
    "E30-4": ("AeroTech E30T", 4),
    "J350-10": ("AeroTech J350W", 10),
    "E16-4": ("Estes E16", 4),
    "D12-0": ("Estes D12", 0),
}

SEVERAL = (
    "3 B6-4, C6-5",
    "3 B6-4",
    "D12-0 ½ A8-5",
    "C6-0/C6-5",
    "2 F101-5",
    "3xD12-5",
    "4 × C6-3",
    "E190-H148R",
    "B6-4, 3 A8-3",
    "D12-0 + C6-7",
    "D12-5 x2",
    "Estes C6-5 (x3)",
)


def _label(motor: Motor) -> str:
    return f"{motor.maker} {motor.designation}"


@pytest.mark.parametrize(
    ("text", "older", "made"), [("G80T-4", "PML G80T", "AeroTech G80T"), ("E12-10", "", "Estes E12")]
)
def test_a_discontinued_motor_is_not_silently_chosen_for_its_delay(text: str, older: str, made: str) -> None:
    found = catalogue().resolve(text)
    assert older in _label(found.motor)
    assert not found.motor.available
    assert "it could also be" in found.notes[0]
    assert made in found.notes[0]


@pytest.mark.parametrize(("text", "expected"), UNMISTAKABLE.items())
def test_a_name_as_flyers_write_it_finds_its_motor(text: str, expected: tuple[str, float | None]) -> None:
    found = catalogue().find(text)
    assert (_label(found.motor), found.delay) == expected
    assert catalogue().resolve(text).motor is found.motor


@pytest.mark.parametrize("text", ["I285-CL", "K940 White Thunder", "J293BS", "G106SK", "K2045 V-max", "F79-13A SS"])
def test_the_propellant_in_a_name_is_that_of_the_motor(text: str) -> None:
    assert catalogue().resolve(text).notes == ()


def test_a_propellant_that_a_motor_does_not_burn_gives_a_note() -> None:
    (note,) = catalogue().resolve("J293WT").notes
    assert "does not have the letters WT" in note


@pytest.mark.parametrize(("text", "expected"), LIKELY.items())
def test_of_several_motors_the_most_likely_is_chosen_and_the_others_are_named(
    text: str, expected: tuple[str, float | None]
) -> None:
    found = catalogue().resolve(text)
    assert (_label(found.motor), found.delay) == expected
    if text != "G75-11":  # only one of them is sold with 11 s
        assert "it could also be" in found.notes[0]
        with pytest.raises(AmbiguousMotor, match=_label(found.motor)):
            catalogue().find(text)


def test_an_ambiguous_name_lists_each_motor_on_a_line_with_the_differences() -> None:
    with pytest.raises(AmbiguousMotor) as caught:
        catalogue().find("38mm H123")
    assert str(caught.value).splitlines()[1:] == [
        "  AeroTech H123W: class H, 38 mm, 223.6 N s, delays 4, 6, 8, 10",
        "  Cesaroni 232H123-14A: class H, 38 mm, 232.4 N s, delays 5, 7, 9, 11, 14",
    ]


def test_the_manufacturer_may_be_given_separately() -> None:
    assert _label(catalogue().find("C6-5", maker="estes").motor) == "Estes C6"


@pytest.mark.parametrize("text", SEVERAL)
def test_clusters_and_stages_are_refused_by_name(text: str) -> None:
    assert is_cluster(text)
    with pytest.raises(UnknownMotor, match="flights on clusters and stages are not used in any fit"):
        catalogue().resolve(text)


@pytest.mark.parametrize("text", [*UNMISTAKABLE, *LIKELY])
def test_a_single_motor_is_not_a_cluster(text: str) -> None:
    assert not is_cluster(text)


@pytest.mark.parametrize(
    ("text", "nearest"),
    [
        ("F38", "AeroTech F39T"),
        ("F101-5", "Cesaroni 56F120-14A"),
        ("F24T", "AeroTech F24W"),
        ("Estes F24", "AeroTech F24W"),
        ("micro max", "Quest MICRO_MAXX"),
        ("banana F24", "AeroTech F24W"),
        ("", "a name such as F24-4W"),
        ("F24-W4", "did you mean F24-4W (AeroTech F24W)?"),
        ("P4935", "above O"),
        ("O10000 (Kosdon)", "Cesaroni 40960O8000-P"),
        ("F24-X9", "did you mean F24-9X?"),
        ("F244W", "did you mean F24-4W (AeroTech F24W)?"),
        ("C65", "did you mean C6-5 ("),
        ("C66-5", "did you mean Estes C6"),
    ],
)
def test_for_an_unknown_motor_the_nearest_names_are_suggested(text: str, nearest: str) -> None:
    for search in (catalogue().find, catalogue().resolve):
        with pytest.raises(UnknownMotor) as caught:
            search(text)
        assert nearest in str(caught.value)


@pytest.mark.parametrize("text", ["C6-r", "C6-RC", "H128W-M"])
def test_a_delay_that_is_neither_a_number_nor_p_is_doubted(text: str) -> None:
    found = catalogue().resolve(text)
    assert found.delay is None
    assert found.doubt == catalogue().doubt(text)
    assert found.doubt in found.notes
    assert "expected seconds, or P for plugged" in found.doubt


def test_no_name_in_the_catalog_is_doubted() -> None:
    labels = [motor.label for motors in catalogue().listings.values() for motor in motors]
    assert not [label for label in labels if catalogue().doubt(label)]
    assert not any(map(catalogue().doubt, ("C6", "C6-7", "C6-P", "F24-W", "", "ZZ99")))


@examples(40)
@given(st.one_of(st.text(max_size=20), st.from_regex(r"[A-O0-9/ ½-]{1,12}", fullmatch=True)))
def test_any_text_finds_a_motor_or_gives_a_clear_error(text: str) -> None:
    is_cluster(text)
    catalogue().search(text)
    for search in (catalogue().find, catalogue().resolve):
        try:
            answer = search(text).motor.designation
        except (UnknownMotor, AmbiguousMotor) as error:
            answer = str(error)
        assert answer


def test_a_delay_that_is_not_sold_gives_a_note_and_not_a_refusal() -> None:
    assert catalogue().find("F24-4").notes == ()
    assert catalogue().find("F24-6").notes == ("AeroTech F24W is not sold with a delay of 6 s, only with 4, 7",)
    assert catalogue().find("F24-P").notes == ("AeroTech F24W is not sold plugged, only with 4, 7",)


def test_an_estimated_mass_is_reported() -> None:
    found = catalogue().find("G35-4")
    assert found.motor.estimated == ("casing mass",)
    assert "casing mass not listed, estimated" in found.notes[0]


def test_every_motor_is_found_by_manufacturer_and_designation() -> None:
    for motor in catalogue().motors:
        assert not is_cluster(motor.designation)
        assert catalogue().find(_label(motor)).motor is motor


def test_every_curve_is_complete_and_has_its_certified_impulse() -> None:
    assert len(catalogue()) == len(catalogue().motors) == catalogue().about["kept"]
    for motor in catalogue().motors:
        assert motor.time[0] == motor.thrust[0] == motor.thrust[-1] == 0
        assert (np.diff(motor.time) > 0).all()
        assert (motor.thrust >= 0).all()
        assert impulse(motor.time, motor.thrust) == pytest.approx(motor.total_impulse, rel=1e-9)
        assert 0 < motor.burn_time <= motor.thrust_end
        assert motor.propellant_mass > 0
        assert motor.casing_mass > 0
        assert motor.loaded_mass == pytest.approx(motor.propellant_mass + motor.casing_mass)
        assert 0 < motor.diameter < 0.2 < 3 * motor.length + 0.2


def test_the_shipped_f24_is_the_certified_one() -> None:
    """Source: certification by NAR as ThrustCurve.org lists it."""
    motor = catalogue().find("F24").motor
    assert motor.total_impulse == 47.31
    assert motor.propellant_mass == pytest.approx(0.0190)
    assert motor.casing_mass == pytest.approx(0.0439)
    assert motor.peak_thrust == pytest.approx(41.0, abs=1.0)
    assert motor.burn_time == pytest.approx(2.0, abs=0.05)
    assert (motor.impulse_class, motor.kind, motor.delays) == ("F", "reload", (4.0, 7.0))
    assert (motor.diameter, motor.length) == (0.024, 0.070)


def test_no_motor_up_to_class_f_was_left_out() -> None:
    """The classes that most flyers use; records of large hybrids have gaps."""
    for letter, (read, kept) in catalogue().about["by_class"].items():
        assert read == kept or letter > "F", letter


def test_the_counts_of_the_catalog_add_up() -> None:
    about = catalogue().about
    assert about["kept"] + sum(map(len, about["left_out"].values())) == about["read"]
    assert sum(about["by_maker"].values()) == about["kept"]
    assert {"source", "version", "date", "licence"} <= set(about)


def test_searching_ranks_the_intended_motor_first() -> None:
    def first(text: str) -> str:
        return _label(catalogue().search(text)[0])

    assert first("F39T-6") == "AeroTech F39T"
    assert first("C6-5") == "Estes C6"
    assert first("white lightning 24mm f") == "AeroTech F24W"
    assert all(motor.name.startswith("F3") for motor in catalogue().search("f3"))
    assert {motor.case for motor in catalogue().search("rms-24/40")} == {"RMS-24/40"}
    assert len(catalogue().search("")) == len(catalogue())
    assert _label(catalogue().search("microm4xx")[0]).startswith("Quest MICRO_MAXX")


def test_own_motors_take_precedence_over_the_catalog() -> None:
    shipped = catalogue().find("Estes C6").motor
    renamed = Motor(**{name: getattr(shipped, name) for name in Motor.__slots__} | {"source": "mine.eng"})
    mine = catalogue().with_motors([renamed])
    assert mine.find("C6-5").motor is renamed
    assert mine.search("c6")[0] is renamed
    assert len(mine) == len(catalogue()) + 1
    assert catalogue().find("Estes C6").motor is shipped


@pytest.mark.parametrize(
    "text",
    ["MyBrand B77-3", "mybrand b77-3", "MyBrand Rocket-Works B77-3", "B77-3 MyBrand", "B77-3 (MyBrand)", "B77-3"],
)
def test_a_motor_in_the_flyers_file_is_found_by_its_manufacturer(text: str) -> None:
    file = b"; mine\nB77 18 70 3-5 0.006 0.018 MyBrand Rocket Works\n 0.1 8\n 0.9 3\n 1.0 0\n"
    found = catalogue().with_motors(own.read(file, "mine.eng")).find(text)
    assert (_label(found.motor), found.delay, found.notes) == ("MyBrand Rocket Works B77", 3, ())
    with pytest.raises(UnknownMotor):
        catalogue().find(text)


def test_manufacturers_in_own_files_do_not_replace_known_ones() -> None:
    file = b"B77 18 70 3 0.006 0.018 AT Labs\n 0.1 8\n 1.0 0\nC9 18 70 3 0.006 0.018 Estes\n 0.1 8\n 1.0 0\n"
    motors = catalogue().with_motors(own.read(file, "mine.eng"))
    assert _label(motors.find("AT F24-4W").motor) == "AeroTech F24W"
    assert _label(motors.find("Estes Industries D12-5").motor) == "Estes D12"
    assert _label(motors.find("AT Labs B77-3").motor) == "AT Labs B77"


def test_a_typed_longest_delay_is_the_one_to_drill_from() -> None:
    found = catalogue().find("H128W-14A")
    assert (found.motor.delays, found.delay) == ((14.0,), 14.0)
    assert not any("delay" in note for note in found.notes)
    assert catalogue().find("H128W-14A").motor is found.motor
    drill = drill_of(found.motor)
    assert drill is not None
    assert sorted(offered(found.motor, drill.takes_off)) == [6.0, 8.0, 10.0, 12.0, 14.0]
    assert catalogue().find("H128W").motor.delays == (4.0, 6.0, 8.0, 10.0)
    assert "outdated; give the longest delay on the package" in catalogue().find("H128W-14").notes[1]
    assert catalogue().find("H238T-14A").motor is catalogue().find("H238T").motor


def test_a_description_is_ready_for_json() -> None:
    description = describe(catalogue().find("A10-PT").motor)
    assert description["delays"] == [0.0, 3.0, "P"]
    assert description["propellant_g"] == pytest.approx(3.6)
    assert description["class"] == "A"
    assert all(math.isfinite(value) for value in description.values() if isinstance(value, float))


@pytest.mark.skipif(not LAUNCHES.exists(), reason="the journal of launches is not part of the project")
def test_every_motor_in_a_real_launch_journal_is_recognized() -> None:
    with LAUNCHES.open(encoding="cp1252", newline="") as file:
        motors = [row["Motors"] for row in csv.DictReader(file)]
    unknown = [text for text in motors if not is_cluster(text) and not _resolves(catalogue(), text)]
    assert len(motors) > 300
    assert unknown == []


def _resolves(motors: Catalogue, text: str) -> bool:
    try:
        return motors.resolve(text).motor.total_impulse > 0
    except FieldkitError:
        return False


@pytest.mark.benchmark(group="motors")
def test_the_catalog_loads_from_its_file(benchmark: BenchmarkFixture) -> None:
    def load() -> Catalogue:
        catalogue.cache_clear()
        return catalogue()

    assert len(benchmark(load)) > 900


@pytest.mark.benchmark(group="motors")
def test_a_name_is_found(benchmark: BenchmarkFixture) -> None:
    motors = catalogue()
    assert benchmark(motors.find, "F24-4W").delay == 4


@pytest.mark.parametrize("text", ["Q99", "AeroTech Q99-7", "P49", "p4935", "Z1"])
def test_a_class_without_motors_is_not_answered_with_another_motor(text: str, run: Run) -> None:
    assert not catalogue().search(text)
    assert "above O" in run("motors", text, status=1).err


def test_motors_with_only_similar_names_are_listed_as_such(run: Run) -> None:
    assert catalogue().search("J9999")[0].name.startswith("J")
    assert not catalogue().knows("J9999")
    assert "nearest names" in run("motors", "J9999").err
    for strict in (["--json"], ["--shortlist-for", "Astra"]):
        printed = run("motors", "J9999", *strict, status=1)
        assert not printed.out
        assert "did you mean AeroTech J99N, AeroTech J1799N" in printed.err


@pytest.mark.parametrize(
    ("typed", "written"),
    [
        ("f24w-4", "F24W-4"),
        ("aerotech f24-4w", "AeroTech F24-4W"),
        ("3 x c6-5", "3 x C6-5"),
        ("d12-5 lot ab12", "D12-5 lot ab12"),
        ("1/2a3-2t", "1/2A3-2T"),
        ("f24 white lightning", "F24 white lightning"),
        ("Kosdon by AeroTech K550W-P", "Kosdon by AeroTech K550W-P"),
    ],
)
def test_a_name_typed_in_small_letters_is_written_as_on_the_motor(typed: str, written: str) -> None:
    assert read_answer("motor", typed) == written


def test_no_name_in_the_catalog_is_written_otherwise() -> None:
    names = [f"{motor.maker} {motor.designation}" for motor in catalogue().search("")]
    assert [in_capitals(name) for name in names] == names
