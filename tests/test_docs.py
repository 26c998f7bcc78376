"""README and manual are correct: commands run, paths exist, examples work, generated pages are up to date."""

import ast
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.core import TyperGroup
from typer.main import get_command

from fieldkit import cli
from fieldkit.cli import main as commands
from fieldkit.cli.formula_text import formula_text
from fieldkit.cli.main import HOMES, app, main
from fieldkit.errors import DamagedLog
from fieldkit.flight import Flight, columns
from fieldkit.flight.plausibility import IMPULSE_SCATTER
from fieldkit.ledger import Ledger
from fieldkit.motors.delay_tolerance import RELATIVE_DELAY_TOLERANCE
from fieldkit.motors.motor import BURN_THRUST_FRACTION
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.physics.flight import fly
from fieldkit.physics.paper import paper_setup
from fieldkit.physics.single import at_the_edge
from fieldkit.tui import page, screens
from fieldkit.units import FOOT
from studies.quick_network import page as quick_page
from tests.commands import Run
from tests.pressing import opened, press, text_of
from tests.user_units import foreign_figures
from tests.vocabulary import unlisted
from tools import benchmarks, evidence
from tools.manual import pages
from tools.strings import listed

CHECK_SHAPES = False

ROOT = Path(__file__).parents[1]
QUICK = ROOT / "docs" / "measured" / "quick_network.json"
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = {path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"))}
ALTIMETERS = ("altimetertwo", "perfectflite", "altos", "eggtimer", "rrc3", "blue-raven")
"""Pages of loggers, with what the import of a file answers."""
NOT_SHIPPED = ("journal", "real-histories")
"""Pages whose commands need flights that are not shipped."""
SLOW = ("after-flight", "contest", "evidence", "landing", "loop", "planning", "safety")
"""Pages whose sessions take seconds."""
OWN_UNITS = {"inspect", "docs", "contest", "finals", "season"}
"""Commands that quote a file's columns, the manual, or a contest's rule."""
OPEN = {"tui", "serve"}
"""Commands that stay open; the tests of the app start them."""
PROPER_NAMES = """
    Astra Comet Coker Entacore Kieffer Kosdon Missile Nitrous Pnut RoadRunner Robert John SCR TSP contributors
    dev fps https isc license mDACS public works www
"""
"""Names of rockets, makers, people, licenses and devices in the examples, and units of a file."""
TO_BE_MADE = {
    "parsers/skylark.py",
    "models/effects/sticky_altimeter.py",
    "fieldkit/tui/screens/weather.py",
    ".venv/bin",
}
"""Paths that the reader creates."""
MADE = {
    "flights.csv",
    "flights.json",
    "card.pdf",
    "finals.png",
    "log-book.csv",
    "log-book-us.csv",
    "sheet.pdf",
    "track.kml",
}
"""Files that the examples write."""


def blocks(language: str, page: str = README) -> list[str]:
    """The fenced blocks of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)


def quoted(page: str) -> Iterator[str]:
    """Everything in a page's running text that is set as code."""
    text = re.sub(r"^```.*?^```$", "", page, flags=re.MULTILINE | re.DOTALL)
    yield from (" ".join(code.split()) for code in re.findall(r"`([^`]+)`", text))


SETUP, *EXAMPLES, TESTS = [block.strip() for block in blocks("sh")]


def lines_of(name: str) -> list[str]:
    """The command lines of a session: the README's, a page's, or a file of examples."""
    if name.endswith(".sh"):
        text = (ROOT / "docs" / name).read_text(encoding="utf-8")
    else:
        text = "".join(block + "\n" for block in EXAMPLES) if name == "README" else "".join(blocks("sh", PAGES[name]))
    text = re.sub(r" &&\n *", "\n", text).replace(".venv/bin/fieldkit", "fieldkit")
    return [line for line in text.splitlines() if line and not line.startswith("#")]


RUN = [
    pytest.param(name, marks=pytest.mark.thorough) if name in SLOW else name
    for name in PAGES
    if not name.startswith("commands") and name not in (*NOT_SHIPPED, ALTIMETERS[0])  # run beside its answers
    if any(line.startswith("fieldkit ") for line in lines_of(name))
]
"""Pages whose commands are run, each as a separate session."""


@pytest.mark.usefixtures("at_the_root")
@pytest.mark.parametrize("name", ALTIMETERS)
def test_an_import_answers_a_user_with_us_units_as_the_page_of_its_altimeter_says(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    session = re.findall(r"^```sh\n(.*?)^```(?:\n\n```\n(.*?)^```)?", PAGES[name], flags=re.MULTILINE | re.DOTALL)
    assert any(answer for _, answer in session)
    assert main(["units", "US"]) == 0
    capsys.readouterr()
    for command, answer in session:
        assert main(shlex.split(command)[1:]) == 0
        shown = capsys.readouterr()
        printed = " ".join((shown.err + shown.out).split())
        assert [line for line in answer.splitlines() if line not in printed] == []


@pytest.fixture
def at_the_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shell in the checkout with an empty ledger."""
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(ROOT)


@pytest.mark.usefixtures("at_the_root")
@pytest.mark.parametrize("name", ["README", *RUN, pytest.param("examples.sh", marks=pytest.mark.thorough)])
def test_the_examples_run_one_after_another(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They show no feet, ounces or miles per hour to a user with SI units, and no words that a translator would not
    find among the program's texts."""
    lines = lines_of(name)
    assert lines
    for line in lines:
        program, *arguments = shlex.split(line)
        assert program == "fieldkit"
        arguments = [str(tmp_path / one) if one in MADE else one for one in arguments]
        assert main(arguments) == 0, line
        shown = capsys.readouterr()
        if arguments[0] not in OWN_UNITS:
            assert foreign_figures(shown.out + shown.err, "SI") == [], line
        if arguments[0] != "docs" and "--json" not in arguments:
            assert unlisted(shown.out + shown.err, f"{' '.join(arguments)} {PROPER_NAMES} {tmp_path}") == [], line


@pytest.mark.parametrize("line", lines_of("examples-long.sh"))
def test_the_long_examples_are_valid(line: str) -> None:
    assert main([*shlex.split(line)[1:], "--help"]) == 0


@pytest.mark.slow
@pytest.mark.train
@pytest.mark.timeout(0)
def test_the_long_examples_run(at_the_root: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that end, beside the files that they name."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "bench" / "faults" / "samples" / "skylark.ork", tmp_path)
    for name in ("anna.csv", "ben.csv"):
        shutil.copy(REFERENCE_FLIGHTS, tmp_path / name)
    assert main(["import", "anna.csv"]) == 0
    for line in lines_of("examples-long.sh"):
        _, *arguments = shlex.split(line)
        if arguments[0] not in OPEN:
            assert main(arguments) == 0, line


def test_the_commands_of_every_page_run() -> None:
    """Those on the pages of commands are the examples; other pages are run, or only their options are checked."""
    shown = {*lines_of("examples.sh"), *lines_of("examples-long.sh")}
    listed = {line for name in PAGES if name.startswith("commands") for line in lines_of(name)}
    assert listed == shown
    assert len(RUN) > 15


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_no_page_is_longer_than_two_thousand_words(page: str) -> None:
    assert len(page.split()) <= (800 if page == PAGES["evidence"] else 2000)


@pytest.mark.parametrize("name", PAGES)
def test_code_is_not_broken_by_a_terminal_of_eighty_columns(name: str) -> None:
    """Long commands are continued on the next line by `fieldkit docs` itself."""
    code = [block for language in ("python", "toml", "console") for block in blocks(language, PAGES[name])]
    assert [line for block in code for line in block.splitlines() if len(line) > 78] == []


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_every_block_of_code_is_of_a_kind_that_a_test_runs(page: str) -> None:
    """Blocks of `sh` and `python` are run; those of `console` are usages in `docs/commands.md` and the installation."""
    fences = re.findall(r"^```(\w*)\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
    printed = {""} if page in [PAGES[name] for name in ALTIMETERS] else set()  # what a command prints
    assert {language for language, _ in fences} <= {"sh", "python", "console", "math", "toml"} | printed
    shown = [line for language, block in fences if language == "console" for line in block.splitlines()]
    assert [line for line in shown if not line.startswith("$ fieldkit ") and line != "pipx install ."] == []
    assert not blocks("python", page) or page == PAGES["extending"]
    assert not blocks("toml", page) or page == PAGES["safety"]


@pytest.mark.usefixtures("at_the_root")
def test_the_rules_of_the_manual_are_applied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (block,) = blocks("toml", PAGES["safety"])
    (tmp_path / "rules").mkdir()
    (tmp_path / "rules" / "moorland.toml").write_text(block, encoding="utf-8")
    plan = ["--motor", "C6-5", "--dry-mass", "70g", "--diameter", "42mm", "--wind", "8.5m/s"]
    assert main(["predict", *plan, "--rules", "Moorland,FAA", "--json"]) == 0
    (made,) = json.loads(capsys.readouterr().out)["predictions"]
    (wind,) = [line for line in made["safety"] if line["check"] == "ground wind"]
    assert wind["verdict"] == "caution"
    assert "unverified" in str(wind)


def test_formulas_are_lines_of_text_in_the_terminal() -> None:
    formulas = [block for page in PAGES for block in blocks("math", PAGES[page])]
    assert len(formulas) > 10
    for line in (line for formula in formulas for line in formula_text(formula).splitlines()):
        assert not set(line) & set("\\{}")
        assert len(line) < 76
    assert (
        formula_text(r"\frac{v_1^2 + c}{2 g} \sqrt{x}, \qquad \vec u = 10^{-3}") == "(v_1² + c)/(2 g) √x,\nu = 10^(-3)"
    )


def test_the_claims_of_the_readme_are_the_output_of_commands() -> None:
    claims = " ".join(README.split())
    _, contest, reference = (
        {
            name: found
            for name, *found in re.findall(
                r"^\| ([\w, ]+) \| (\d+) \| ([\d.]+) \| ([\d.]+) \| [-\d.]+ \| ([\d.]+) \|", table, flags=re.MULTILINE
            )
        }
        for table in re.split(r"^## .*: ", PAGES["held-out"], flags=re.MULTILINE)
        if table.startswith("rockets flown before")
    )

    def best(table: dict[str, list[str]]) -> list[str]:
        """The simple rule with the lowest CRPS: flights, median and mean error, CRPS."""
        return min((row for name, row in table.items() if name not in evidence.OWN), key=lambda row: float(row[3]))

    def feet(error: str) -> str:
        """An error [percent of the apogee] at 800 ft. [ft]"""
        return f"{8 * float(error):.0f}"

    flights, median, mean, _ = contest["fieldkit"]
    assert f"at 800 ft, half of {flights} contest flights miss by less than {feet(median)} ft (best plain" in claims
    rule, one = best(contest), contest["uncalibrated"]
    assert (
        f"plain rule {feet(rule[1])} ft; one simulation with Cd 0.6: {feet(one[1])} ft, but {feet(one[2])} ft on"
        in claims
    )
    assert f"on average, fieldkit {feet(mean)} ft)" in claims
    assert reference["fieldkit"][0] == "7"
    rule, own = best(reference), reference["fieldkit"]
    assert f"on seven flights of a paper the rule wins, {feet(rule[1])} ft to {feet(own[1])} ft" in claims
    before, after = re.findall(r"miss by ([\d.]+) m with no correction, by ([\d.]+) m with it", PAGES["evidence"])[0]
    assert f"hardly improved, {float(before) / FOOT:.0f} ft off to {float(after) / FOOT:.0f} ft" in claims


def test_the_verdicts_in_the_readme_are_those_of_the_page() -> None:
    claims, page = " ".join(README.split()), PAGES["undeclared-effects"]
    right = re.search(r"In decidable histories, (\d+ of \d+) verdicts are right", page)
    assert right is not None
    assert f"where it matters, {right[1]} verdicts are right" in claims
    named = re.findall(r"named at 80% or more: (\d+) of (\d+) histories, 0 with an effect that is not there", page)
    names, histories = (sum(map(int, column)) for column in zip(*named, strict=True))
    assert f"in {histories} simulated seasons all {names} causes named at 80% or more were there" in claims
    nulls = [int(count) for count in re.findall(r"false alarms on nulls: 0 of (\d+),", page)]
    assert f"0 of {sum(nulls)} without one got a name" in claims


def test_the_names_in_the_manual_are_those_of_the_page_of_hidden_effects() -> None:
    page = " ".join(PAGES["undeclared-effects"].split())
    found = re.search(r"; (\d+) of \d+ histories\), (\d+) get a name, (\d+) of them a false one", page)
    assert found is not None
    histories, named, false = found.groups()
    words = {"3": "three", "4": "four"}
    evidence_page, loop = (" ".join(PAGES[name].split()) for name in ("evidence", "loop"))
    assert f"of {histories} seasons with an effect it named {named}, {words[false]} of them wrongly" in evidence_page
    assert f"of {histories} seasons that scatter like real flights and have an effect, it named {named} (" in loop


def test_the_pictures_of_measured_flights_show_the_figures_of_the_pages() -> None:
    """Those that need no fit are drawn again."""
    for name, draw in (("brakes", evidence.brakes_picture), ("scores", evidence.scores_picture)):
        assert (ROOT / "docs" / f"evidence_{name}.svg").read_text(encoding="utf-8") == draw(), (
            "python -m tools.evidence"
        )
    page, text = PAGES["real-forces"], " ".join(PAGES["evidence"].split())
    left_out = re.search(r"mean error ([\d.]+) m.*?verdict ([\d.]+) m.*?and ([\d.]+) m if", page, flags=re.DOTALL)
    step = re.search(r"probability (\d+%).*?by ([\d.]+ ± [\d.]+);", page, flags=re.DOTALL)
    assert left_out is not None
    assert step is not None
    assert "miss by {} m with no correction, by {} m with it, and by {} m if".format(*left_out.groups()) in text
    assert f"with a probability of {step[1]}" in text
    assert f"a factor of {step[2]}" in text


def test_causes_and_shared_motors_on_the_page_of_evidence_are_those_measured() -> None:
    text = " ".join(PAGES["evidence"].split())
    found = json.loads((ROOT / "docs" / "measured" / "evidence.json").read_text(encoding="utf-8"))
    causes, shared = found["journal"]["causes"], found["journal"]["shared"]
    words = {1: "one", 2: "two", 3: "three", 4: "four"}
    assert f"Of {words[causes['noted']]} flights whose notes state a cause" in text
    assert f"right for {words[causes['first']]}, and the right one is among the three most" in text
    assert f"probable for {words[causes['among_three']]}," in text
    assert f"Of the {causes['others']} others {words[len(causes['named'])]} are named" in text
    (misread,) = re.findall(r"average acceleration (\d+%) high", " ".join(causes["named"]))
    assert f"one average acceleration was {misread} too high" in text
    assert f"{shared['n_flights']} normal flights of {shared['n_rockets']} rockets" in text
    assert found["contest"]["shared"]["findings"] == []
    (motor,) = shared["findings"]
    assert re.search(r"\d+% more thrust", motor["why"])[0] in text  # type: ignore[index]
    assert f"a probability of {motor['probability']:.0%}" in text
    assert "from {} m to {} m with".format(*(f"{motor[key]['mae_m']:.1f}" for key in ("before", "after"))) in text
    last = next(one for one in shared["rivals"] if one["name"] == "last on motor, else last ratio")
    assert f"misses by {last['mae_m']:.1f} m" in text


@pytest.mark.thorough
def test_the_picture_of_single_flights_is_of_this_model() -> None:
    assert (ROOT / "docs" / "evidence_one_offs.svg").read_text(encoding="utf-8") == evidence.one_offs_picture()


def test_every_command_has_an_example() -> None:
    pages = "".join(page for name, page in PAGES.items() if name.startswith("commands-"))
    commands = re.findall(r"^## `fieldkit (\w+)`", pages, flags=re.MULTILINE)
    shown = {shlex.split(line)[1] for name in ("examples.sh", "examples-long.sh") for line in lines_of(name)}
    assert len(commands) >= 30
    assert set(commands) == shown == set(HOMES)


def test_the_generated_pages_are_up_to_date() -> None:
    for path, text in pages():
        assert path.read_text(encoding="utf-8") == text, f"python tools/manual.py writes {path.name} again"


def test_a_limit_of_nfpa_1125_is_stated_as_one_figure() -> None:
    known = {f"{100 * limit:g}%" for limit in (BURN_THRUST_FRACTION, IMPULSE_SCATTER, RELATIVE_DELAY_TOLERANCE)}
    files = [file for folder in ("fieldkit", "models", "tools", "docs") for file in (ROOT / folder).rglob("*.py")]
    texts = {file.name: " ".join(file.read_text(encoding="utf-8").split()) for file in files} | PAGES
    figure = re.compile(r"((?<![.\d])\d[\d.]*%)[^%;]{0,60}\(NFPA 1125\)|NFPA 1125[^%;)]{1,60}?((?<![.\d])\d[\d.]*%)")
    stated = {name: {one or other for one, other in figure.findall(text)} for name, text in texts.items()}
    assert sum(map(bool, stated.values())) >= 6
    assert {name: found - known for name, found in stated.items() if found - known} == {}


def test_the_page_of_speed_is_of_the_latest_saved_runs() -> None:
    text = "\n".join(benchmarks.page(benchmarks.latest())) + "\n"
    assert PAGES["speed"] == text, "python tools/benchmarks.py --page writes it again"


def test_the_comparison_of_quick_answers_with_networks_is_up_to_date() -> None:
    text = "\n".join(quick_page.page(json.loads(QUICK.read_text(encoding="utf-8")))).rstrip() + "\n"
    assert QUICK.with_suffix(".md").read_text(encoding="utf-8") == text, "python -m tools.quick_network writes it"
    better = re.search(r"has a CRPS ([\d.]+)% better", text)
    assert better is not None
    assert f"has a CRPS {better[1]}% lower" in PAGES["quick-answers"]


def test_the_first_page_links_to_all_others_like_the_site() -> None:
    linked = re.findall(r"\]\((\w[\w-]*)\.md\)", PAGES["index"])
    assert sorted(["index", *linked]) == sorted(PAGES)
    assert re.findall(r"- ([\w-]+)\.md$", (ROOT / "mkdocs.yml").read_text(), flags=re.MULTILINE) == ["index", *linked]


@pytest.mark.sampled
@pytest.mark.parametrize("page", ["", "phys", *PAGES])
def test_the_manual_can_be_read_in_the_terminal(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["docs", *([page] if page else [])]) == 0
    printed = capsys.readouterr().out
    text = PAGES["physics" if page == "phys" else page or "index"]
    title = re.findall(r"^# (.*)$", text, flags=re.MULTILINE)[0]
    assert title.replace("`", "") in " ".join(printed.split())


def test_for_a_missing_page_the_existing_ones_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["docs", "xyzzy"]) == 1
    assert "no page 'xyzzy', expected one of: index, installing, start" in capsys.readouterr().err


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_every_command_and_option_that_is_mentioned_exists(page: str) -> None:
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    for text in quoted(page):
        program, *words = text.split()
        if program != "fieldkit" or not words or not re.fullmatch(r"[a-z]+", words[0]):
            continue
        command = group.commands[words[0]]
        known = {option for parameter in command.params for option in parameter.opts} | {"--help"}
        assert isinstance(command, TyperGroup) or {word for word in words if word.startswith("--")} <= known, text


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_every_option_that_is_mentioned_by_itself_exists(page: str) -> None:
    """Options after the name of a program are those of the two tests beside this one."""
    options = [word for text in quoted(page) if text.startswith("--") for word in text.split() if word.startswith("--")]
    assert [option for option in options if option.partition("=")[0].rstrip(",") not in every_option()] == []


@cache
def every_option() -> set[str]:
    """The options of all commands."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    commands: list[Any] = [group, *group.commands.values()]
    commands += [
        one for command in commands[1:] if isinstance(command, TyperGroup) for one in command.commands.values()
    ]
    parameters = [one for command in commands for one in command.params]
    return {"--help"} | {option for one in parameters for option in (*one.opts, *one.secondary_opts)}


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_every_path_that_is_mentioned_exists(page: str) -> None:
    words = {word for text in quoted(page) for word in text.split()}
    words |= set(re.findall(r"\]\((docs/[^)#]+)\)", page))
    tops = {path.name for path in ROOT.iterdir()}
    paths = {word for word in words if re.fullmatch(r"\.?[\w]+(/[\w.-]+)+/?", word) and word.split("/")[0] in tops}
    for path in paths - TO_BE_MADE:
        assert (ROOT / path).exists(), path


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_every_tool_and_option_that_is_mentioned_exists(page: str) -> None:
    """Programs of the checkout, which take minutes or need other people's data, are not run: their names and options
    are looked up in their code."""
    lines = [line for block in blocks("sh", page) for line in block.splitlines()]
    for text in [*quoted(page), *lines]:
        program, *words = text.split() or [""]
        if program != "python" or not words:
            continue
        name = words[1].replace(".", "/") if words[0] == "-m" else words[0].removesuffix(".py")
        if name.split("/")[0] not in ("bench", "studies", "tools"):
            continue
        assert (ROOT / f"{name}.py").exists() or (ROOT / name / "__main__.py").exists(), text
        code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / name.split("/")[0]).rglob("*.py"))
        assert [word for word in words if word.startswith("--") and f'"{word}"' not in code] == [], text


@pytest.mark.parametrize("name", NOT_SHIPPED)
def test_commands_on_flights_that_are_not_shipped_are_valid(name: str) -> None:
    for line in lines_of(name):
        assert main([*shlex.split(line)[1:], "--help"]) == 0, line


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_every_table_has_an_empty_line_above(page: str) -> None:
    """Without it, Markdown shows the rows as running text."""
    lines = page.splitlines()
    heads = [i - 1 for i, line in enumerate(lines) if re.fullmatch(r"\|(-+\|)+", line)]
    assert [lines[i] for i in heads if i and lines[i - 1]] == []


def test_ci_runs_the_command_of_the_readme_with_the_training_extra() -> None:
    """It prints the block with the program of `.ci/run`, which finds it by the words before it."""
    assert "pytest" in TESTS
    assert "train" not in TESTS, "torch is gigabytes on Linux"
    lines = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    assert any(line.startswith("python3 -m venv .venv && ") and "'.[train]'" in line for line in lines)
    (program,) = re.findall(r"awk '(.*)' README\.md", "\n".join(lines))
    found = subprocess.run(["awk", program, "README.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == TESTS


def test_messages_quoted_in_the_manual_are_in_the_program() -> None:
    sources = [path for folder in ("fieldkit", "parsers") for path in (ROOT / folder).rglob("*.py")]
    program = "".join(re.sub(r'"\s+f?"', "", path.read_text(encoding="utf-8")) for path in sources)  # split texts
    heads = re.findall(r"^\*\*(.*?)\*\*", PAGES["troubleshooting"], flags=re.MULTILINE)
    quotes = [words for head in heads for words in re.findall(r"`([^`]+)`", head)]
    missing = [words for words in quotes if re.sub(r"^(1|the file is) ", "", words) not in program]
    assert len(quotes) > 8
    assert missing == ["fieldkit: command not found"], "a shell's own words"


def test_the_first_command_ends_in_the_demo() -> None:
    assert "pip install ." in SETUP
    assert SETUP.endswith("fieldkit demo")


def test_the_example_parser_of_the_manual_works() -> None:
    parser, *_ = blocks("python", PAGES["extending"])
    module: dict[str, object] = {}
    exec(compile(parser, "skylark.py", "exec"), module)
    skylark = module["PARSER"]
    log = b"SKYLARK 2\n0.00,0\n0.05,12.5\n0.10,100\n"
    assert skylark.recognises(log)
    (reading,) = skylark.read(log)
    (series,) = reading.clocks
    assert series.time.tolist() == [0.0, 0.05, 0.1]
    assert series.altitude.tolist() == pytest.approx([0.0, 3.81, 30.48])
    with pytest.raises(DamagedLog, match=r"row 3: found '0\.05'"):
        skylark.read(b"SKYLARK 2\n0.00,0\n0.05\n")


def test_the_helpers_in_the_manual_are_those_that_parsers_use() -> None:
    """Each named helper is used by two parsers or more, and what four or more use is named."""
    rows = re.findall(r"^\| (`.*?) \| `fieldkit/[^|]*\|", PAGES["extending"], flags=re.MULTILINE)
    helpers = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    used = Counter(
        name.name
        for path in (ROOT / "parsers").glob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("fieldkit.")
        for name in node.names
        if node.module != "fieldkit.shapes"  # array types, which all code uses
    )
    assert len(helpers) > 20
    assert [name for name in helpers if used[name] < 2] == []
    assert [name for name, count in used.items() if count >= 4 and name not in helpers] == []


def test_the_messages_explained_in_troubleshooting_are_in_the_program() -> None:
    headings = re.findall(r"^\*\*(`.*?)\*\*", PAGES["troubleshooting"], flags=re.MULTILINE)
    messages = [message for heading in headings for message in re.findall(r"`([^`]+)`", heading)]
    parts = [
        part.strip(" :;,.")
        for line in listed()
        for part in line.split(": ", 1)[1].split("{...}")
        if len(part.strip()) >= 10  # longer than a word or two
    ]
    of_the_shell = ["fieldkit: command not found"]
    assert len(messages) > 8
    unknown = [one for one in messages if not any(one in part or part in one for part in parts)]
    assert unknown == of_the_shell


def test_the_example_column_of_the_manual_is_one() -> None:
    (example,) = re.findall(r"`(_column\(.*?\))`", PAGES["extending"])
    column = eval(example, {"_column": columns._column})
    assert (column.header, column.low, column.high) == ("gusts_mps", 0.0, 20.0)


def test_names_that_extending_says_to_be_in_a_file_are_defined_there() -> None:
    named = re.findall(r"`(\w+(?:\.\w+)?)`\s(?:of|in)\s`(fieldkit/[\w/]+\.py)`", PAGES["extending"])
    assert len(named) >= 3
    for name, path in named:
        source = (ROOT / path).read_text(encoding="utf-8")
        assert re.search(rf"^(class|def) {name.split('.')[0]}\b|^{name} ?[:=]", source, flags=re.MULTILINE), (
            name,
            path,
        )


def test_the_example_effect_of_the_manual_changes_the_reading() -> None:
    _, effect, *_ = blocks("python", PAGES["extending"])
    module: dict[str, object] = {}
    exec(compile(effect, "sticky_altimeter.py", "exec"), module)
    sticky = module["EFFECT"]
    readings = {"apogee": np.array([[100.0, 200.0]]), "top_speed": np.array([[50.0, 60.0]])}
    bent = sticky.bend_reading(readings, np.array([[2.0, 2.0]]))
    assert bent["apogee"].tolist() == [[98.0, 198.0]]
    assert bent["top_speed"].tolist() == [[50.0, 60.0]]


async def test_the_example_screen_of_the_manual_shows_the_wind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "weather.py").write_text(blocks("python", PAGES["extending"])[2], encoding="utf-8")
    monkeypatch.setattr(screens, "__path__", [*screens.__path__, str(tmp_path)])
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([Flight(flight_id="1", rocket="Astra", wind=3.5), Flight(flight_id="2", rocket="Astra")])
    try:
        page.pages.cache_clear()
        async with opened(tmp_path / "ledger.db") as pilot:
            await press(pilot, "8")
            assert text_of(pilot, "#body Static") == "Astra 1: 3.5 m/s"
    finally:
        page.pages.cache_clear()
        sys.modules.pop(f"{screens.__name__}.weather", None)


def test_the_example_command_of_the_manual_plans_from_what_is_known(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rail.py").write_text(blocks("python", PAGES["extending"])[3], encoding="utf-8")
    monkeypatch.setattr(cli, "__path__", [*cli.__path__, str(tmp_path)])
    monkeypatch.setitem(commands.HOMES, "rail", "rail")
    plan = ["rail", "--rocket", "Bertha", "--motor", "C6-5"]
    try:
        printed = run(*plan, "--dry-mass", "80g", "--diameter", "41.6mm", "--rail-length", "1m").out
        assert re.search(r"off the rail at \d+\.\d m/s", printed)
        assert run(*plan, "--json").document["rail_speed_mps"] > 5, "the rocket is remembered"
    finally:
        sys.modules.pop(f"{cli.__name__}.rail", None)


def test_a_readout_that_is_only_recorded_is_not_simulated() -> None:
    flown = fly(paper_setup(np.array([0]), np.array([0.3]), np.array([0.6]), np.array([1.0])))
    assert at_the_edge(flown, ["apogee", "coast_drag"]).keys() == {"apogee_m"}
