"""Formulas of the manual as lines of text, for a terminal: `\\frac{a + b}{2}` becomes `(a + b)/2`."""

import re
from collections.abc import Iterator

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|.", flags=re.DOTALL)
_SYMBOLS = {
    "alpha": "α",
    "beta": "β",
    "gamma": "γ",
    "Delta": "Δ",
    "ell": "ℓ",
    "mu": "μ",
    "nu": "ν",
    "pi": "π",
    "rho": "ρ",
    "theta": "θ",
    "varepsilon": "ε",
    "int": "∫",
    "sim": "~",
    "ln": "ln ",
    "cosh": "cosh ",
    "quad": "\n",
    "qquad": "\n",
    ",": " ",
    ";": " ",
    "left": "",
    "right": "",
}
_ONLY_THEIR_ARGUMENT = {"vec", "hat", "mathrm", "mathcal"}
_SINGLE = re.compile(r"[\d.]+|d?[^\W\d]\w?'?[²³]?|[^\W\d]_\w+[²³]?")
"""One number, quantity or differential."""
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def formula_text(latex: str) -> str:
    """A formula in LaTeX as text, a line for each part between wide spaces. Raises KeyError for a command that it does
    not know."""
    text = _sequence(iter(_TOKEN.findall(" ".join(latex.split()))))
    return "\n".join(" ".join(line.split()) for line in text.splitlines())


def _sequence(tokens: Iterator[str]) -> str:
    """Everything up to the end of the group."""
    return "".join(_one(token, tokens) for token in iter(lambda: next(tokens, "}"), "}"))


def _one(token: str, tokens: Iterator[str]) -> str:
    """What a token and its arguments become."""
    name = token.removeprefix("\\")
    if token == "{":
        return _sequence(tokens)
    if token in ("^", "_"):
        part = _argument(tokens)
        return part.translate(_RAISED) if token == "^" and part.isdigit() else token + _whole(part, token == "_")
    if token == "\\frac":
        return f"{_whole(_argument(tokens))}/{_whole(_argument(tokens))}"
    if token == "\\sqrt":
        return f"√{_whole(_argument(tokens))}"
    if name in _ONLY_THEIR_ARGUMENT:
        return _argument(tokens)
    return token if token == name else _SYMBOLS[name]


def _argument(tokens: Iterator[str]) -> str:
    """The next token with its own arguments, without the spaces around it."""
    first = next(token for token in tokens if not token.isspace())
    return _one(first, tokens).strip()


def _whole(part: str, is_name: bool = False) -> str:
    """A part in parentheses, unless it is a single one or a name."""
    return part if is_name or _SINGLE.fullmatch(part) else f"({part})"
