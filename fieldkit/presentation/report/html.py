"""HTML pages from templates: text from files is escaped, and scripts cannot run."""

from base64 import b64encode
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from fieldkit.safe_text import printable


def rendered(template: str, content: Mapping[str, Any]) -> str:
    """A template of this package with its content in place."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined  # takes 0.04 s to import

    def load(name: str) -> str:
        return files("fieldkit.presentation.report").joinpath(name).read_text(encoding="utf-8")

    environment = Environment(
        loader=FunctionLoader(load),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        finalize=lambda value: printable(value) if type(value) is str else value,
        keep_trailing_newline=True,
    )
    return environment.get_template(template).render(content)


def embedded(picture: bytes) -> str:
    """An SVG as the source of an image in the page itself."""
    return f"data:image/svg+xml;base64,{b64encode(picture).decode()}"
