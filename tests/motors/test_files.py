"""The flyer's own motor files: RASP and RockSim, valid and damaged."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.errors import DamagedLog
from fieldkit.motors import PLUGGED_DELAY, Motor, catalogue
from fieldkit.motors.draft import PER_IMPULSE
from fieldkit.motors.own import import_file, known_motors, own_motors, read, sound_motors, unreported
from tests.effort import examples

pytestmark = pytest.mark.fast

ENG = b"""; two motors of my own
; the second has no comment before it
F24W 24 70 4-7 0.019 0.0629 AT
   0.014 36.1
   0.5   30.0 ; steady
   2.13  0
Sugar-1 38 250 P 0.2 0.45 Garden Shed
   0.1 100
   1.5 100
   1.6 0
"""

RSE = b"""<?xml version="1.0" encoding="ISO-8859-1"?>
<engine-database>
 <engine-list>
  <engine mfg="Estes" code="C6" Type="single-use" dia="18." len="70." initWt="24.1" propWt="10.8"
    delays="0,3,5,1000" auto-calc-mass="0" Itot="8.82">
   <comments>one of mine</comments>
   <data>
    <eng-data t="0." f="0." m="10.8" cg="35."/>
    <eng-data t="0.2" f="14." m="9." cg="35."/>
    <eng-data t="1.86" f="0." m="0." cg="35."/>
   </data>
  </engine>
 </engine-list>
</engine-database>
"""


def _one_of_the_catalogue() -> st.SearchStrategy[Motor]:
    return st.sampled_from(catalogue().motors)


def as_rasp_file(motor: Motor) -> bytes:
    """A motor as a RASP file, with full precision. Delays that are not recorded become a dash."""
    delay = "-".join("P" if delay == PLUGGED_DELAY else f"{delay:g}" for delay in motor.delays) or "-"
    numbers = (motor.diameter * 1e3, motor.length * 1e3, delay, motor.propellant_mass, motor.loaded_mass)
    words = [number if isinstance(number, str) else f"{number:.12g}" for number in numbers]
    header = " ".join(["_".join(motor.designation.split()), *words, motor.maker or "unknown"])
    samples = [f"   {float(t)!r} {float(f)!r}" for t, f in zip(motor.time[1:], motor.thrust[1:], strict=True)]
    return "\n".join([f"; {motor.maker} {motor.designation}, {motor.source}", header, *samples, ";", ""]).encode()


@given(_one_of_the_catalogue())
def test_a_motor_written_as_a_rasp_file_round_trips(motor: Motor) -> None:
    [back] = read(as_rasp_file(motor), "mine.eng")
    for field in ("maker", "designation", "delays"):
        assert getattr(back, field) == getattr(motor, field)
    for field in ("diameter", "length", "propellant_mass", "casing_mass", "total_impulse", "burn_time"):
        assert getattr(back, field) == pytest.approx(getattr(motor, field), rel=1e-9)
    np.testing.assert_allclose(back.time, motor.time, rtol=1e-12)
    np.testing.assert_allclose(back.thrust, motor.thrust, rtol=1e-9, atol=1e-12)


def test_a_rasp_file_may_hold_several_motors() -> None:
    first, second = read(ENG, "mine.eng")
    assert (first.maker, first.name, first.designation, first.delays) == ("AeroTech", "F24", "F24W", (4, 7))
    assert first.propellant_mass == 0.019
    assert first.casing_mass == pytest.approx(0.0439)
    assert (first.time[0], first.thrust[0], first.source) == (0, 0, "mine.eng")
    assert (second.maker, second.delays, second.impulse_class) == ("Garden Shed", (PLUGGED_DELAY,), "G")
    assert second.total_impulse == pytest.approx(0.05 * 100 + 140 + 5)


def test_a_rasp_file_from_windows_with_a_byte_order_mark_and_tabs_is_read() -> None:
    text = ENG.decode().replace("\n", "\r\n").replace("   ", "\t")
    assert len(read(b"\xef\xbb\xbf" + text.encode(), "mine.eng")) == 2
    assert len(read(text.replace("my own", "J\xfcrgen").encode("cp1252"), "mine.eng")) == 2


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("0.5   30.0", "0.5 3o.0", "mine.eng, row 5, thrust: found '3o.0', expected a number (N)"),
        ("0.5   30.0", "0.01 30.0", "mine.eng, row 5: found the time 0.01 after 0.014"),
        ("0.5   30.0", "0.5 -30.0", "mine.eng, row 5: found 0.5 s, -30 N, expected neither to be negative"),
        (
            "0.5   30.0",
            "0.5 30 0",
            "mine.eng, row 5: found '0.5 30 0', expected `seconds newtons` or a header",
        ),
        ("   2.13  0\n", "", "mine.eng, row 5: found a curve of 16.3 N s that ends at 30 N, expected 0"),
        ("F24W 24 70", "F24W 0.024 70", "mine.eng, row 3, diameter: found '0.024', expected more than 1 mm"),
        ("0.019 0.0629", "19 62.9", "mine.eng, row 3: found 19 kg of propellant"),
        ("0.019 0.0629", "0.0629 0.019", "mine.eng, row 3: found 62.9 g of propellant in a motor of 19 g"),
        ("4-7", "4-x7", "mine.eng, row 3, delays: found 'X7', expected delays such as 4-7-10 or P"),
        ("F24W 24 70 4-7", "F24W", "mine.eng, row 3: found 'F24W 0.019 0.0629 AT', expected a header"),
    ],
)
def test_for_a_damaged_rasp_file_the_line_and_the_expected_content_are_named(
    old: str, new: str, complaint: str
) -> None:
    with pytest.raises(DamagedLog) as caught:
        read(ENG.decode().replace(old, new).encode(), "mine.eng")
    assert complaint in str(caught.value)


def test_a_curve_without_its_last_zero_falls_to_zero_there() -> None:
    first, second = read(ENG.replace(b"2.13  0", b"2.13 20"), "mine.eng")
    ending = "mine.eng, row 6: the curve ends at 20 N, taken to fall to 0 there: the file may be cut short"
    assert first.remarks == (f"{ending}, and apogees too low, {PER_IMPULSE}",)
    assert first.thrust_end == pytest.approx(2.13, abs=1e-3)
    assert first.total_impulse == pytest.approx(0.5 * 0.014 * 36.1 + 0.486 * 33.05 + 1.63 * 25, rel=1e-3)
    assert second.remarks == ()


def test_negative_noise_of_a_test_stand_counts_as_zero() -> None:
    first, _ = read(ENG.replace(b"2.13  0", b"2.1 -0.4\n2.13 0.1\n2.2 -0.1"), "mine.eng")
    assert first.remarks == ("mine.eng, row 6: 2 thrusts down to -0.4 N taken as 0",)
    assert first.thrust.min() == 0


@pytest.mark.parametrize(
    "data",
    [
        ENG + b"\x1a",
        ENG + b"\0" * 200,
        ENG + b"\x1a\0\0garbage",
        ENG.decode().encode("utf-16"),
        ENG.decode().encode("utf-16-le"),
        b"\xfe\xff" + ENG.decode().encode("utf-16-be"),
        ENG.replace(b"; ", b"# "),
        ENG.replace(b"; ", b"// "),
        ENG.replace(b"; ", b"//"),
    ],
)
def test_a_rasp_file_with_another_ending_encoding_or_comment_is_read(data: bytes) -> None:
    assert [motor.designation for motor in read(data, "mine.eng")] == ["F24W", "Sugar-1"]


@pytest.mark.parametrize(
    "data",
    [
        RSE + b"\x1a",
        RSE + b"\0\0",
        RSE.decode().replace("ISO-8859-1", "UTF-16").encode("utf-16"),
        RSE.replace(b"ISO-8859-1", b"utf-8").replace(b"one of mine", b"29\xb0C"),
        RSE.replace(b'<?xml version="1.0" encoding="ISO-8859-1"?>\n', b"\xef\xbb\xbf"),
    ],
)
def test_a_rocksim_file_with_another_ending_or_encoding_is_read(data: bytes) -> None:
    assert [motor.designation for motor in read(data, "mine.rse")] == ["C6"]


@pytest.mark.parametrize("data", [b"", b"; only a comment\n", b"\n\n"])
def test_a_rasp_file_without_a_motor_reports_it(data: bytes) -> None:
    with pytest.raises(DamagedLog, match="found no motor, expected a header"):
        read(data, "mine.eng")


def test_a_header_without_samples_is_damaged() -> None:
    with pytest.raises(DamagedLog, match="row 1: found no thrust for F24W"):
        read(b"F24W 24 70 4-7 0.019 0.0629 AT\n;\n", "mine.eng")


def test_a_rocksim_file_is_read_in_grams() -> None:
    [motor] = read(RSE, "mine.rse")
    assert (motor.maker, motor.name, motor.kind, motor.delays) == ("Estes", "C6", "SU", (0, 3, 5, PLUGGED_DELAY))
    assert motor.propellant_mass == pytest.approx(0.0108)
    assert motor.casing_mass == pytest.approx(0.0133)
    assert motor.diameter == pytest.approx(0.018)
    assert motor.total_impulse == pytest.approx(0.5 * 1.86 * 14)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('propWt="10.8"', "", "mine.rse, row 4, propWt: found <engine> without propWt="),
        ('f="14."', 'f="l4."', "mine.rse, row 9, f: found 'l4.', expected a number (N)"),
        ("</data>", "", "mine.rse, row 12: found broken XML (mismatched tag"),
        ("engine mfg", "motor mfg", "mine.rse, row 8: found <eng-data>, expected an <engine> around it"),
        ("ISO-8859-1", "no-such", "mine.rse, row 1: found an encoding that cannot be read (unknown encoding"),
    ],
)
def test_for_a_damaged_rocksim_file_the_line_is_named(old: str, new: str, complaint: str) -> None:
    data = RSE.decode().replace(old, new).replace("</engine>", "</motor>" if "motor" in new else "</engine>")
    with pytest.raises(DamagedLog) as caught:
        read(data.encode(), "mine.rse")
    assert complaint in str(caught.value)


@pytest.mark.parametrize(
    "entity", ['<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">', '<!ENTITY b SYSTEM "file:///etc/passwd">']
)
def test_a_rocksim_file_with_entities_is_refused_before_they_are_read(entity: str) -> None:
    bomb = RSE.replace(b"<engine-database>", f"<!DOCTYPE e [{entity}]>\n<engine-database>".encode())
    with pytest.raises(DamagedLog, match=r"row 2: found a document type declaration"):
        read(bomb.replace(b"one of mine", b"&b;"), "mine.rse")


@st.composite
def _mutated(draw: st.DrawFn) -> bytes:
    data = bytearray(draw(st.sampled_from([ENG, RSE])))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(data)))
        stop = draw(st.integers(start, min(len(data), start + 40)))
        data[start:stop] = draw(
            st.one_of(st.binary(max_size=8), st.sampled_from([b"1e308", b"-", b"\n", b"0", b"nan"]))
        )
    return bytes(data[: draw(st.integers(0, len(data)))] if draw(st.booleans()) else data)


@given(_mutated())
@examples(300)
def test_a_truncated_motor_file_is_damaged_or_still_complete_but_never_a_crash(data: bytes) -> None:
    try:
        motors = read(data, "torn")
    except DamagedLog as error:
        where = (error.source, error.row is not None)
        motors = []
    else:
        where = ("torn", bool(motors))
    assert where == ("torn", True)
    for motor in motors:
        assert np.isfinite(motor.thrust).all()
        assert (np.diff(motor.time) > 0).all()
        assert motor.burn_time > 0


@given(st.binary(max_size=60))
def test_no_bytes_cause_a_crash(data: bytes) -> None:
    with pytest.raises(DamagedLog):
        read(data, "noise")


def test_a_damaged_file_in_the_folder_of_own_motors_does_not_affect_the_others(tmp_path: Path) -> None:
    assert own_motors(tmp_path / "nothing here") == ([], [])
    (tmp_path / "a.eng").write_bytes(ENG)
    (tmp_path / "b.RSE").write_bytes(RSE)
    (tmp_path / "c.eng").write_bytes(ENG[:90])
    (tmp_path / "notes.txt").write_text("no motor")
    motors, errors = own_motors(tmp_path)
    assert [motor.designation for motor in motors] == ["F24W", "Sugar-1", "C6"]
    assert len(errors) == 1
    assert "c.eng" in str(errors[0])


def test_an_error_is_reported_once_for_each_change_of_the_files(tmp_path: Path) -> None:
    def reported() -> list[str]:
        return [str(error) for error in unreported(known_motors(tmp_path)[1], tmp_path)]

    (tmp_path / "sound.eng").write_bytes(ENG)
    assert reported() == []
    assert {path.name for path in tmp_path.iterdir()} == {"sound.eng"}
    (tmp_path / "bad.eng").write_bytes(ENG[:90])
    assert "bad.eng" in reported()[0]
    assert reported() == []
    (tmp_path / "bad.eng").write_bytes(ENG[:91])
    assert "bad.eng" in reported()[0]
    (tmp_path / "bad.eng").write_bytes(ENG)
    assert reported() == []
    (tmp_path / "bad.eng").write_bytes(ENG[:91])
    assert "bad.eng" in reported()[0]


def test_an_imported_file_is_kept_and_its_motor_is_found(tmp_path: Path) -> None:
    (tmp_path / "mine.eng").write_bytes(ENG)
    import_file(tmp_path / "mine.eng", tmp_path / "motors")
    motors, _ = own_motors(tmp_path / "motors")
    mine = catalogue().with_motors(motors)
    assert mine.find("F24-4W").motor.source == "mine.eng"
    assert mine.find("sugar-1").motor.designation == "Sugar-1"
    with pytest.raises(DamagedLog, match=r"gone\.eng: cannot be read"):
        import_file(tmp_path / "gone.eng", tmp_path / "motors")


def test_a_damaged_file_is_not_kept(tmp_path: Path) -> None:
    (tmp_path / "torn.eng").write_bytes(ENG[:90])
    with pytest.raises(DamagedLog):
        import_file(tmp_path / "torn.eng", tmp_path / "motors")
    assert not (tmp_path / "motors").exists()


def test_a_changed_motor_is_a_different_motor() -> None:
    motor = catalogue().find("F24").motor
    assert dataclasses.replace(motor, total_impulse=40.0) != motor


CUT_SHORT = """R11 24 70 4 0.012 0.040 Lab
0.02 5
0.9 9
1 0
R12 24 70 4 0.012 0.040 Lab
0.02 5
R13 24 70 4 0.012 0.040 Lab
0.02 6
0.9 10
1 0
"""


@pytest.mark.parametrize(
    ("damage", "row"),
    [
        ("0.02 5\nR13", 5),
        ("0.02 five\nR13", 6),
        ("R12 24 70 4 0.012 0.040 Lab", 5),
        ("R12 24 seventy 4 0.012 0.040 Lab", 5),
    ],
)
def test_a_damaged_motor_does_not_affect_the_others_of_its_file(damage: str, row: int) -> None:
    old = "0.02 5\nR13" if damage.endswith("R13") else "R12 24 70 4 0.012 0.040 Lab"
    motors, (error,) = sound_motors(CUT_SHORT.replace(old, damage).encode(), "three.eng")
    assert [motor.designation for motor in motors] == ["R11", "R13"]
    assert (error.source, error.row) == ("three.eng", row)


def test_a_damaged_motor_does_not_affect_the_others_of_a_rocksim_file() -> None:
    engine = RSE[RSE.index(b"<engine ") : RSE.index(b"</engine>") + len(b"</engine>")]
    bad = engine.replace(b'code="C6"', b'code="C7"').replace(b'f="14.', b'f="l4.')
    assert bad.count(b"l4.") == 1
    whole = RSE.replace(engine, engine + b"\n" + bad + b"\n" + engine.replace(b'code="C6"', b'code="C8"'))
    motors, (error,) = sound_motors(whole, "three.rse")
    assert [motor.designation for motor in motors] == ["C6", "C8"]
    assert "l4." in str(error)
