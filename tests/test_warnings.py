"""Every warning that a figure may be off says which way, and by how much; the others are listed here."""

import re

import pytest

from fieldkit.analysis import notes
from tools.strings import listed

pytestmark = pytest.mark.fast

WARNS = re.compile(
    r"\b(assum|not given|not modeled|as if|provisional|standard values|unverified|outdated|taken (to|for)|doubtful|"
    r"default;|leave[s]? out|off by|not checked|delay unknown)"
)
DIRECTION = re.compile(
    r"either way|too (high|low|narrow|wide|few|early|late)|higher|lower|faster|slower|late\b|early|stricter|laxer|"
    r"between|at least|weaker|stronger|narrower|wider|farther|±|\d%|falls|drift"
)
NOTHING = re.compile(r"\bno (rocket flight|apogee|burn time|top speed|duration|height)|not measured")
"""A measurement that is left out is not off."""
LIMITS_WITHOUT_A_FIGURE = {
    "{...}; distance not given": "the limit is printed, nothing is forecast",
    "the code requires {...} across{...}; field size not given": "the limit is printed, nothing is forecast",
    "not given; {...}": "the limit is printed",
    "not given; at most {...}°": "the limit is printed; the plan's line `with` says what 5 degrees do",
    "{...}, not checked against this season's rules": "the season it is from is printed",
    "not checked": "a heading",
    "{...} not checked, or to be checked by you:": "a heading",
    "{...} not given": "a heading",
    "wind not given": "a heading; the forecast beside it says what a breeze does",
    "standard air, wind not given": "a heading; the forecast beside it says what they do",
    "not given": "a cell; the forecast beside it says what a standard value does",
    "not given: press p on the Fly page to enter it": "a cell",
    "No map: the wind was not given": "nothing is drawn",
    "caution, not given, not final": "a legend",
    "{...}; standard values for {...}": "each value is followed by what it does (`planning.air`)",
    "? not checked, inputs missing: {...}": "nothing is forecast",
    "delay unknown: {...}": "motors without a time of the charge",
    "delay unknown; add it to the motor's name, as in F24-4W": "no time of the charge",
    "delay unknown: add it to the motor's name, as in F24-4W; the landing assumes a charge at apogee": "`OFF_APOGEE`",
    "a plugged motor has no charge: an altimeter must deploy; the landing assumes that it does at apogee": "sized",
    "{...}; wind not given; {...}": "followed by how far it drifts for each m/s",
    "{...}: take a longer delay or leave out the charge": "the speed is printed",
    "note: the map assumes a wind from {...}° (west); another, by --wind-from, turns the map": "a picture's direction",
    "days were hotter or colder than assumed, which changes both drag and the altimeter reading": "an effect's name",
    "the altimeter's heights are off by a constant percentage, while speed and times are right": "an effect's name",
    "each figure of the curve / of the record; {...}, {...} with a curve that is not the recorded one; off by more "
    "than {...} in impulse, burn time or average thrust: {...}; in peak thrust: {...}": "a table's legend",
    "4. The loop: what forecasts leave out, and by how much they miss": "a heading",
    "not modeled for stages: every part needs its own recovery": "no landing speed",
    "{...} motors, forecast as if every one lights: {...}": "`one_unlit` follows",
    "ceiling not given: no motor is excluded by its height; give --waiver, or save the site's": "too many motors",
    "field not given: no motor is excluded for needing a larger one; give --field-size, or save the site's": "too many",
    "that delay list is outdated; give the longest delay on the package, as in {...}-14A": "a refusal",
    "were not checked against its instructions ({...})": "followed by what a cut that is 1 s off does",
    "{...}: this delay list is outdated, and the package may list more than {...} s": "the delay may be longer",
    "timer {...}:00, t starts it; the length is unverified, ask at the event": "a rule, not a figure of ours",
    "mass of the file doubtful": "beside the recorded mass",
    "a cluster: thrusts are added as if every motor lights; the delay counts from the end of the last burn; changes in "
    "drag and failed ignitions are not modeled: {...}": "`one_unlit` follows",
    "off by up to {...}": "the lengths of names",
    "{...} taken for {...}": "a guess at what was typed, beside by how much it differs",
    ", for a diameter usual at its mass: its own is not given": "the interval is wider for it",
}
"""Warnings without a direction, and why."""
NOT_OURS = (
    "fieldkit/inference",
    "fieldkit/reference",
    "fieldkit/capture",
    "fieldkit/model/",
    "parsers",
    "fieldkit/tui/loop",
)


def test_every_warning_says_which_way_the_figure_errs() -> None:
    shown = {line.split(": ", 1)[1] for line in listed() if not line.startswith(NOT_OURS)}
    warnings = {text for text in shown if WARNS.search(text) and not text.endswith(".") and "expected" not in text}
    bare = {text for text in warnings if not DIRECTION.search(text)}
    assert len(warnings) > 40
    assert bare == LIMITS_WITHOUT_A_FIGURE.keys()


def test_every_note_on_a_log_says_what_is_missing_or_which_way_it_errs() -> None:
    every = {name: text for name, text in vars(notes).items() if name.isupper()}
    named_elsewhere = {"UNCHECKED_NOTE", "OTHER_FLIGHT", "EARLIER_FLIGHT"}  # within a note; about a flight not measured
    assert len(every) > 20
    silent = [name for name, text in every.items() if not DIRECTION.search(text) and not NOTHING.search(text)]
    assert set(silent) <= named_elsewhere | {"NO_HEIGHT"}
