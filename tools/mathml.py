"""A hook of mkdocs: formulas in blocks of `math` become MathML, which browsers render without scripts or a network."""

import re
from typing import Any

from latex2mathml.converter import convert

FORMULA = re.compile(r"^```math\n(.*?)^```$", flags=re.MULTILINE | re.DOTALL)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """A page's text with its formulas as MathML."""
    return FORMULA.sub(lambda block: f"<div>{convert(block[1].strip(), display='block')}</div>", markdown)
