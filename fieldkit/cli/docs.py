"""`fieldkit docs`: the manual in the terminal, page by page; it is installed with the program."""

import re
from pathlib import Path
from textwrap import wrap
from typing import Annotated

import typer

from fieldkit.cli.formula_text import formula_text
from fieldkit.cli.main import EXPLAINED_ON
from fieldkit.cli.screen import print_table, say
from fieldkit.errors import BadValue, unknown
from fieldkit.plugins import plugin_folder

app = typer.Typer()
COMMAND_WIDTH = 76
"""Longest line of a command before its backslash. [character]"""

LINK = r"\[([^]]+)\]\(([\w./-]+)(?:#[\w-]+)?\)"
"""A link to another page, or to a file of the repository that is not installed: its text and its target."""


def page_names(incomplete: str = "") -> list[str]:
    """Pages of the manual whose names begin with a text, in the order of its first page."""
    linked = re.findall(r"\]\((\w[\w-]*)\.md\)", _text("index"))
    return [name for name in dict.fromkeys(["index", *linked]) if name.startswith(incomplete)]


@app.command()
def docs(
    page: Annotated[
        str,
        typer.Argument(
            metavar="PAGE", help="Name of the page, or its first letters, or a command.", autocompletion=page_names
        ),
    ] = "",
) -> None:
    """Print a page of the manual; without a page, list them."""
    from rich.console import Console

    from fieldkit.cli.manual_tables import Manual

    if not page:
        print_table(("page", ""), _contents())
        say()
        say("To print a page: fieldkit docs start")
        return
    found = [page] if page in page_names() else page_names(page) or _about_command(page)
    if len(found) != 1:
        raise BadValue(unknown("page", page, found or page_names()))
    Console(highlight=False).print(Manual(_readable(_text(found[0]))))


def _about_command(name: str) -> list[str]:
    """The page that explains a command, or else that lists it; none for another name."""
    listed = (page for page in page_names("commands-") if f"## `fieldkit {name}`\n" in _text(page))
    found = EXPLAINED_ON.get(name) or next(listed, None)
    return [found] if found else []


def _contents() -> list[tuple[str, str]]:
    """The pages with their titles below the headings of the first page, with an empty row above each heading."""
    rows = [("index", _title("index"))]
    for heading, name in re.findall(r"^\*\*(.+)\*\*$|\]\((\w[\w-]*)\.md\)", _text("index"), flags=re.MULTILINE):
        rows += [("", ""), (heading, "")] if heading else [(name, _title(name))]
    return rows


def _text(name: str) -> str:
    return Path(plugin_folder("docs") / f"{name}.md").read_text(encoding="utf-8")


def _title(name: str) -> str:
    return next(line.removeprefix("# ") for line in _text(name).splitlines() if line.startswith("# "))


def _readable(text: str) -> str:
    """A page with pictures replaced by what they show, links by the commands that print those pages, formulas as text,
    and with long commands continued on the next line so that they can be copied."""
    text = re.sub(r"^!\[([^]]*)\]\([^)]*\)$", r"*Picture: \1*", text, flags=re.MULTILINE)
    text = re.sub(rf"\({LINK}\)", lambda link: f"({link[1]}: `{_place(link[2])}`)", text)
    text = re.sub(LINK, lambda link: f"{link[1]} (`{_place(link[2])}`)", text)
    text = re.sub(
        r"^```math\n(.*?)^```",
        lambda block: f"```\n{formula_text(block[1])}\n```",
        text,
        flags=re.MULTILINE | re.DOTALL,
    )
    text = re.sub(r"^\*\*.*?\*\*", lambda head: head[0].replace("`", '"'), text, flags=re.MULTILINE)  # quoted messages
    return re.sub(r"^```sh\n.*?^```", lambda block: _continued(block[0]), text, flags=re.MULTILINE | re.DOTALL)


def _place(target: str) -> str:
    """What prints the target of a link, or the file that it is."""
    page = Path(target)
    return f"fieldkit docs {page.stem}" if target == f"{page.stem}.md" else f"docs/{target}"


def _continued(block: str) -> str:
    """Commands broken before options, or before their last words, and remarks broken between words, so that each line
    fits 80 columns with a margin on both sides."""
    lines: list[str] = []
    for line in block.splitlines():
        if line.startswith("#"):
            lines += wrap(line, COMMAND_WIDTH, subsequent_indent="# ", break_long_words=False, break_on_hyphens=False)
            continue
        first, *rest = re.split(r" (?=--)", line)
        parts = [first, *rest] if len(first) <= COMMAND_WIDTH else [*first.rsplit(" ", 1), *rest]
        lines.append(parts[0])
        for part in parts[1:]:
            if len(lines[-1]) + len(part) < COMMAND_WIDTH:
                lines[-1] += f" {part}"
            else:
                lines[-1] += " \\"
                lines.append(f"  {part}")
    return "\n".join(lines)
