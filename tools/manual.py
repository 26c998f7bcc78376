"""Writes the generated pages of the manual: `python tools/manual.py`.

`commands.md` from the command line and `docs/examples.sh`, `effects.md` from the effects, `models.md` from the cards of
the trained ensembles, `priors.md` from the hyperprior, `keys.md` from the bindings of the app, `map.md` from the layers
in `pyproject.toml` and the first words of the code. A test compares them with the files.
"""

import ast
import html
import math
import re
import shlex
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from typer.cli import get_docs_for_click
from typer.core import TyperGroup
from typer.main import get_command

from fieldkit.cli.main import SUBJECTS, app
from fieldkit.inference.network.ensemble import read_card
from fieldkit.physics.effect import Effect, Prior, effects
from fieldkit.plugins import trained, trained_digests, trained_folder
from tools.key_page import key_table
from tools.markdown import WRITTEN_BY
from tools.prior_page import prior_scores, prior_table

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
SESSIONS = (DOCS / "examples.sh", DOCS / "examples-long.sh")
"""Files of examples: those that the tests run, and those that stay open or take long."""


def examples() -> dict[str, list[str]]:
    """The lines of the examples by command: comments and command lines, in order."""
    found: dict[str, list[str]] = {}
    remarks: list[str] = []
    texts = (file.read_text(encoding="utf-8").partition("\n\n")[2] for file in SESSIONS)  # without their first remarks
    for line in "\n".join(texts).splitlines():
        if line.startswith("#"):
            remarks.append(line)
        elif line:
            found.setdefault(shlex.split(line)[1], []).extend([*remarks, line])
            remarks = []
    return found


def commands() -> Iterator[tuple[str, str]]:
    """The pages of commands: the list of all, and for each group its commands with help, examples and options."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    context = group.context_class(group, info_name="fieldkit")
    shown = examples()
    heads: dict[str, list[str]] = {}
    parts = []
    for name, command in group.commands.items():
        text = html.unescape(get_docs_for_click(obj=command, ctx=context, name=f"fieldkit {name}", indent=1))
        usage = re.compile(r"\*\*Usage\*\*:\n\n```console\n.*?```\n", flags=re.DOTALL)
        text = re.sub(r"^In the manual: fieldkit docs (\S+)$", r"[More](\1.md).", text, flags=re.MULTILINE)
        lines = "\n".join(shown.get(name, []))
        example = f"```sh\n{lines}\n```\n" if lines else ""
        text = usage.sub("", usage.sub(lambda _: example, text, count=1)).strip()  # noqa: B023  # called here
        parts.append(re.sub(r"\*\*Commands\*\*:\n\n(\* .*\n)+\n", "", text))  # each has its own section below
        heads.setdefault(PAGE_OF[name], []).append(f"`{name}`")
    shared = _options_in_all(part for name, part in zip(group.commands, parts, strict=True) if name in PLANNED)
    parts = [_without(part, shared, name in PLANNED) for name, part in zip(group.commands, parts, strict=True)]
    yield (
        "commands",
        f"""# Every command

Most commands take `--json`, and those that write a file `--force`, to replace one; `fieldkit COMMAND --help` prints all
options. The examples are one session,
`docs/examples.sh`, which the tests run from top to bottom; those of commands that stay open or run for long are in
`docs/examples-long.sh`. {WRITTEN_BY}

The exit status is 0 for success, 2 for wrong usage, and 1 for anything else, with a line on standard error that says
what was found and what was expected. An `import` that rejects rows lists them, imports the others, and exits with 0.

`fieldkit --help` says in a line what each does.

{chr(10).join(f"- [{COMMAND_PAGES[page][0]}]({page}.md): {', '.join(heads[page])}" for page in COMMAND_PAGES)}

## Options of a plan

{_listed(PLANNED)} take these options. What is not given is as in the flight entered last, or standard; the answer
says which.

{chr(10).join(shared)}
""",
    )
    by_name = dict(zip(group.commands, parts, strict=True))
    for page, (title, names) in COMMAND_PAGES.items():
        sections = EVERYWHERE.sub("", (chr(10) * 2).join(by_name[name] for name in names))
        sections = re.sub(r"\n{3,}", "\n\n", sections)
        yield page, f"# {title}\n\nPart of [every command](commands.md). {WRITTEN_BY}\n\n{sections}\n"


COMMAND_PAGES = {
    f"commands-{name}": (f"Commands for {subject[0].lower()}{subject[1:]}", SUBJECTS[subject])
    for name, subject in zip(("flights", "forecasts", "motors", "planning", "ledger", "studies"), SUBJECTS, strict=True)
}
"""Pages of commands: title, and the commands in order."""
EVERYWHERE = re.compile(
    r"^(\*\*Options\*\*:\n\n)?"
    r"(\* `--(json`: Print JSON|help`: Show this message and exit|force`: Replace an existing file)\.\n)+",
    re.MULTILINE,
)
"""The options of all commands, which the first page of commands names, and a list of options that has no others."""
PAGE_OF = {name: page for page, (_, names) in COMMAND_PAGES.items() for name in names}
"""The page of each command."""


PLANNED = ("predict", "motors", "delay", "ballast", "contest", "finals", "season", "landing", "daysheet")
"""Commands that take the options of a plan."""
FEW_SHARED = 4
"""Number of options of a plan from which a command refers to their list. [1]"""


def _options_in_all(parts: Iterable[str]) -> list[str]:
    """The options that are the same in all of some commands, in order."""
    first, *others = [[line for line in part.splitlines() if line.startswith("* `--")] for part in parts]
    general = ("* `--json", "* `--help")
    return [line for line in first if all(line in other for other in others) and not line.startswith(general)]


def _without(part: str, shared: Sequence[str], every: bool) -> str:
    """The section of a command with one line in place of its shared options, which names them unless it has `every`."""
    lines = [line for line in part.splitlines() if line not in shared]
    own = [line for line in part.splitlines() if line in shared]
    if len(own) < FEW_SHARED:
        return part
    place = lines.index("* `--help`: Show this message and exit.")
    names = ", ".join(f"`{one}`" for line in own for one in re.findall(r"(--[\w-]+)(?: [A-Z]|`)", line)[:1])
    linked = "[options of a plan](commands.md#options-of-a-plan)"
    one = f"* The {linked}." if every else f"* {names}: see the {linked}."
    return "\n".join([*lines[:place], one, *lines[place:]])


def _listed(names: Sequence[str]) -> str:
    *most, last = (f"`{name}`" for name in names)
    return f"{', '.join(most)} and {last}"


def effect_table() -> str:
    """Every effect: description, parameter, prior, source."""
    rows = [_effect_row(name, effect) for name, effect in effects().items()]
    return f"""# The effects

What a forecast without a correction may lack. Each is a file in `models/effects/` ([how to add one](extending.md));
each has one strength, which is zero if the effect is absent. [The physics](physics.md) has the equations that they
change, [the loop](loop.md) how one is chosen. Priors are normal distributions, truncated at their bounds; if the
square of the strength is fitted, the prior is of the square. {WRITTEN_BY}

| effect | description | strength | prior | one strength for | source |
|---|---|---|---|---|---|
{chr(10).join(rows)}

## Which flight distinguishes one from another

| effect | what a flyer sees | how to find out |
|---|---|---|
{chr(10).join(f"| `{name}` | {effect.explains} | {effect.tell_apart} |" for name, effect in effects().items())}
"""


def _effect_row(name: str, effect: Effect) -> str:
    strength = f"({effect.unit})²" if effect.squared else effect.unit
    one_for = f"a {effect.per}" if effect.per and not effect.everywhere else f"all, or a {effect.per}"
    cells = (
        f"`{name}`",
        f"{effect.title}{f', a form of `{effect.form_of}`' if effect.form_of else ''}",
        strength,
        _prior(effect.prior) + (f"; every rocket: {_prior(effect.background)}" if effect.background else ""),
        (one_for if effect.per else "all flights") + ("" if effect.from_first else ", from some flight on"),
        effect.source,
    )
    return f"| {' | '.join(cells)} |"


def _prior(prior: Prior) -> str:
    low = f", at least {prior.low:g}" if math.isfinite(prior.low) else ""
    high = f", at most {prior.high:g}" if math.isfinite(prior.high) else ""
    return f"{prior.mean:g} ± {prior.sd:g}{low}{high}"


CARD = ("recipe", "physics", "command", "seed", "n_train", "members", "features", "outputs")
"""Entries of a card that its page lists first."""


def model_cards() -> str:
    """The trained ensembles: training data, settings and command of each."""
    parts = [_card(name, read_card(trained_folder(name))) for name in trained()]
    return f"""# The trained ensembles

The reference paper's network, which estimates drag and thrust from one apogee. It is one ONNX graph, never a pickle,
whose digest is in its card: a graph that differs is refused. `fieldkit --version` prints the digest. It was trained
only on simulated flights. Everything else is answered by the model itself: [quick answers](quick-answers.md) says why.
{WRITTEN_BY}

{(chr(10) * 2).join(parts)}

## What inference is for

For model rockets on certified single-use and reloadable motors up to class I, one stage, one motor, below the speed
of sound or shortly above it. Not for clusters, staging, hybrids, gliders. A flight with a readout that the model's
prior hardly allows for its rocket and motor is answered with a warning. Cd here is that of the altimeter's whole
flight, on the frontal area of the body, fins and base included. Forecasts are advice: at the field the range safety
officer decides.
"""


def _card(name: str, card: Mapping[str, Any]) -> str:
    """The section of an ensemble."""
    first = [f"| {key} | {_text(card[key])} |" for key in CARD if key in card]
    priors = [f"| {key} | {_text(law)} |" for key, law in card["priors"].items()]
    return f"""## `{name}`

| | |
|---|---|
{chr(10).join(first)}
| sha256 | `{trained_digests()[name]}` |

| prior of | |
|---|---|
{chr(10).join(priors)}"""


def _law(prior: Mapping[str, Any]) -> str:
    """A distribution with its numbers and unit: `uniform, 0.3 to 0.9 [1]`."""
    uniform = prior["law"] == "uniform"
    numbers = "{low:g} to {high:g}" if uniform else "mean {mean:g}, sd {sd:g}"
    return f"{prior['law']}, {numbers.format(**prior)} [{prior['unit']}]"


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return _law(value) if "law" in value else ", ".join(f"{key} {item}" for key, item in value.items())
    if isinstance(value, list):
        own = [item for item in value if "." not in str(item)]
        per_effect = dict.fromkeys(item.partition(".")[2] for item in value if item not in own)
        names = ", ".join(f"`{item}`" for item in own)
        return f"{names}; for each effect {', '.join(f'`{item}`' for item in per_effect)}" if per_effect else names
    return f"`{value}`" if "--" in str(value) else str(value)


def code_map() -> str:
    """The map of the code: a row per package, in the order of the layers."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"]
    names = [name for layer in layers for name in re.findall(r"\w+", layer)]
    rows = [f"| `{name}/` | {_first_words(name)} |" for name in names if _is_package(name)]
    return f"""# The map of the code

Bytes of a log become a `Reading` in `parsers/`, a `Flight` in `fieldkit/importing/`, a row of the ledger in
`fieldkit/ledger/ledger.py`, Cd and alpha in `fieldkit/services/inferred.py`, a forecast in
`fieldkit/forecast/predict.py`, and its misses lead to a better model in `fieldkit/selection/diagnose.py`. A module
imports only modules below it in this table, as `lint-imports` checks with the layers in `pyproject.toml`.
{WRITTEN_BY}

| in `fieldkit/` | what it is |
|---|---|
{chr(10).join(rows)}

| next to it | what it is |
|---|---|
| `parsers/` | a file for every logger or table format ([how to add one](extending.md)) |
| `models/effects/` | a file for every [effect](effects.md) |
| `models/trained/` | a folder for every [ensemble](models.md) |
| `sample_logs/` | at least one log for every parser, `PARSER__what_happened.suffix` |
| `studies/` | reference posteriors, causes of the reference paper's bias, effects in real histories; not in the wheel |
| `bench/` | an independent simulator, [tests of the loop](undeclared-effects.md), [the fault bench](faults.md) |
| `tools/` | programs that write pages, pictures, the motor catalog and the samples |
| `tests/` | organized like `fieldkit/`: laws, contracts for every plug-in, golden figures, screens; `benchmarks/` |
"""


def _is_package(name: str) -> bool:
    return (ROOT / "fieldkit" / name).is_dir()


def _first_words(name: str) -> str:
    """The first paragraph of a module's docstring, on one line."""
    folder = ROOT / "fieldkit" / name
    file = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return " ".join(docstring.split("\n\n")[0].split()).replace("|", "\\|")


def pages() -> Iterator[tuple[Path, str]]:
    """Every page that this tool writes, with its text."""
    for name, text in commands():
        yield DOCS / f"{name}.md", text
    written = {"effects": effect_table, "models": model_cards, "map": code_map, "keys": key_table}
    for name, write in {**written, "priors": prior_table, "measured/prior_scores": prior_scores}.items():
        yield DOCS / f"{name}.md", write()


def main() -> None:
    """Write the pages."""
    for path, text in pages():
        path.write_text(text, encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
