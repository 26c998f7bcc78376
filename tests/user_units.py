"""Figures in units of the wrong system, found in what commands print."""

import re

_METRIC = r"1/km|m|m/s|kg|g|mm|cm|km|hPa|°C|K|kg/m³|m/s²|m/s\^2"
_CUSTOMARY = r"ft|mph|oz|lb|in|inHg|°F|lb/ft³|ft/s²|ft/s\^2"
_SUFFIXES = {"US": "m|mps|mm|c|hpa", "SI": "ft|mph|in|oz|lb|f|inhg"}
_FIGURE = {
    system: re.compile(
        rf"(?<![\w.])[-+]?\d[\d.,]*(?:e[-+]?\d+)? (?:{units})(?![\w/^²³])|\[(?:{units})\]"
        rf"|\w_(?:{_SUFFIXES[system]}) +[-+]?\d"
    )
    for system, units in {"US": _METRIC, "SI": _CUSTOMARY}.items()
}
"""A figure with its unit or after the name of a column with it, or a heading with one, by the system in which it has
no place."""
_ELSEWHERE = {
    "quoted rules": r"[“\"][^”\"]*[”\"]",
    "points of a contest": r"(?m)^.* points  .*$",
    "rules of a contest": r"(?m)^( +[✓?!✗] contest |eggs: |body: |launch: |The rule of )(.|\n(?! *[✓?!✗] |\w))*",
    "targets of a contest": r"target \d+ ft",
    "a rule in the words of the code": r"The\s+rule:\s(.|\n(?! *([\w/-]+: )?[✓?!⊘] | *These checks))*",
    "a rule to check oneself": r"distance of complex rockets, but not more than 2,000 ft",
    "rules that only some motors meet": r"occupied buildings: (.|\n(?! *[\w-]+: ))*",
    "dimensions of motors": r"\b(motors|mount) of \d+ mm|│ (diameter|length) +\d+ mm",
    "mounts of kits": r"(?m)(?<= oz) +[\d.]+ in +\d+ mm$",
    "accelerations": r"(?im)^.*acceleration.*$|[-\d.]+ to [-\d.]+ g$",
    "seconds and then a word": r"\b\d[\d.]* in (the|a|all)\b",
}
"""Text with units of its own, as `docs/words.md` states."""


def foreign_figures(text: str, system: str) -> list[str]:
    """Figures in units that a user of a system, `SI` or `US`, did not choose, one per line of text."""
    for own in _ELSEWHERE.values():
        text = re.sub(own, "", text)
    return [line.strip() for line in text.splitlines() if _FIGURE[system].search(line)]
