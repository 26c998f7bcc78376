"""The range safety sheet: every check once, with its rule, what is not known, and room to sign, on one page."""

from pathlib import Path

import pytest

from fieldkit.planning.check import BY_EYE, SafetyCheck
from fieldkit.presentation.report.safety_sheet import sheet_text
from tests.commands import Run

LINES = (
    SafetyCheck("ground wind", "ok", "3 m/s", "the code", "at most 20 mph", "O"),
    SafetyCheck("rail exit speed", "unsafe", "5 m/s", "guidance"),
    SafetyCheck("field size", "unknown", "field size not given", "the code"),
    SafetyCheck("sky", "unknown", f"{BY_EYE}no clouds", "the code"),
)


def test_what_was_checked_what_is_not_known_and_what_is_seen_by_eye_are_apart() -> None:
    text = list(sheet_text(LINES))
    assert text[0] == "CHECKED (2), by rule and source"
    assert text[1].startswith("  ⊘ rail exit speed: unsafe: 5 m/s [guidance]")
    assert text[2] == "  ✓ ground wind: ok: 3 m/s [at most 20 mph; the code]"
    assert text.index("NOT KNOWN (1)") < text.index("CHECKED BY EYE ON THE RANGE (1)")
    assert "  ? field size: field size not given" in text
    assert "  [ ] sky: no clouds" in text


@pytest.mark.parametrize("suffix", [".pdf", ".svg", ".png"])
def test_the_sheet_is_one_page(suffix: str, run: Run, tmp_path: Path) -> None:
    file = tmp_path / f"sheet{suffix}"
    body = ("--rocket", "R", "--motor", "K550W", "--dry-mass", "5kg", "--diameter", "100mm", "--wind", "3m/s")
    printed = run("landing", *body, "--safety-sheet", file)
    assert "Wrote the range safety sheet" in printed.err
    content = file.read_bytes()
    assert len(content) > 10_000
    assert suffix != ".pdf" or content.count(b"/Type /Page ") + content.count(b"/Type /Page\n") == 1


def test_a_sheet_explains_what_is_unverified_if_anything_is() -> None:
    assert not any("no source" in line for line in sheet_text(LINES))
    marked = [*LINES, SafetyCheck("age", "ok", "from 18 years on", "", mark="U")]
    assert any(line.startswith("Unverified: no source of it was at hand") for line in sheet_text(marked))


def test_a_sheet_is_refused_with_another_suffix(run: Run, tmp_path: Path) -> None:
    body = ("--rocket", "R", "--motor", "C6-5", "--dry-mass", "60g", "--diameter", "25mm")
    assert "sheet.txt" in run("landing", *body, "--safety-sheet", tmp_path / "sheet.txt", status=1).err
