"""Flights stored and read, and every change undone, on SQLite and on PostgreSQL if available."""

import os
import random
import re
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import create_engine, text
from sqlalchemy.engine import make_url

from fieldkit.errors import BadValue, LedgerError
from fieldkit.flight import COLUMNS, Flight
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import Ledger, Renewal
from fieldkit.ledger.finding import PAGE
from fieldkit.ledger.records import Added
from tests.effort import examples

pytestmark = pytest.mark.fast

SERVER = os.environ.get("FIELDKIT_TEST_POSTGRES")
needs_server = pytest.mark.skipif(not SERVER, reason="FIELDKIT_TEST_POSTGRES holds no URL")

FIRST = Flight(
    flight_id="1",
    rocket="Astra",
    config="A",
    motor="F24-4W",
    date_time=datetime(2024, 5, 4, 10, 30),
    site="North field",
    tags=("weak_launch", "mine"),
    notes="drifted; found",
    dry_mass=0.322,
    diameter=0.066,
    apogee=281.3,
    extra={"Weather": "grey"},
)
SECOND = FIRST.with_changes(flight_id="2", tags=(), apogee=290.1, extra={}, date_time=datetime(2024, 5, 5))


@pytest.fixture(params=["sqlite", pytest.param("postgres", marks=[pytest.mark.postgres, needs_server])])
def where(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """The URL of an empty ledger."""
    if request.param == "sqlite":
        yield str(tmp_path / "ledger.db")
        return
    pytest.importorskip("psycopg", reason="needs the extra `postgres`")
    url = make_url(str(SERVER)).set(drivername="postgresql+psycopg")
    server = create_engine(url, isolation_level="AUTOCOMMIT")
    name = f"fieldkit_test_{os.environ.get('PYTEST_XDIST_WORKER', 'alone')}"
    with server.connect() as connection:
        connection.execute(text(f"DROP DATABASE IF EXISTS {name}"))
        connection.execute(text(f"CREATE DATABASE {name}"))
    yield url.set(database=name).render_as_string(hide_password=False)
    with server.connect() as connection:
        connection.execute(text(f"DROP DATABASE {name} WITH (FORCE)"))
    server.dispose()


@pytest.fixture
def ledger(where: str) -> Iterator[Ledger]:
    with Ledger.open(where) as ledger:
        yield ledger


words = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12)
zones = st.none() | st.integers(-14 * 60, 14 * 60).map(lambda m: timezone(timedelta(minutes=m)))
numbers = st.none() | st.floats(allow_nan=False, allow_infinity=False)
records = st.builds(
    Flight,
    flight_id=words.filter(bool),
    rocket=words,
    config=words,
    motor=words,
    site=words,
    notes=words,
    log=words,
    date_time=st.none() | st.datetimes(timezones=zones),
    tags=st.lists(words, max_size=3).map(tuple),
    extra=st.dictionaries(words, words, max_size=3),
    **{column.name: numbers for column in COLUMNS},
)


@pytest.mark.parametrize("changes", [{"rocket": "é" * 1300}, {"flight_id": "7" * 2600}, {"tags": ("t" * 2601,)}])
def test_names_longer_than_the_keys_of_a_server_are_refused_in_every_ledger(
    where: str, changes: dict[str, object]
) -> None:
    with Ledger.open(where) as ledger:
        (conflict,) = ledger.add([FIRST.with_changes(**changes)]).conflicts
        assert "bytes, expected at most 2600" in conflict.error
        ledger.add([FIRST])
        with pytest.raises(BadValue, match="bytes, expected at most 2600"):
            ledger.edit("1", **changes)
        assert ledger.flights() == [FIRST]


@pytest.mark.parametrize("letter", ["é", "x"])
def test_the_longest_names_fit_in_every_ledger(where: str, letter: str) -> None:
    some = random.Random(1).choices(f"{letter}abcdefghijklmnop0123456789", k=2599)  # a server compresses what repeats
    name = "".join(some).encode()[:2598].decode(errors="ignore")
    with Ledger.open(where) as ledger:
        assert ledger.add([FIRST.with_changes(rocket=name)]).new


@pytest.mark.parametrize("where", [pytest.param("postgres", marks=[pytest.mark.postgres, needs_server])], indirect=True)
def test_all_pages_show_one_state_of_a_server(ledger: Ledger, where: str) -> None:
    """In SQLite a reader blocks writers instead."""
    count = 2 * PAGE
    ledger.add([FIRST.with_changes(flight_id=str(number)) for number in range(count)])
    pages = ledger.summaries()
    listed = len(next(pages))
    with Ledger.open(where) as other:
        other.remove(str(count - 1))
        other.edit(str(count - 2), notes="edited meanwhile")
    assert listed + sum(map(len, pages)) == count
    assert sum(map(len, ledger.summaries())) == count - 1


def test_ledger_in_ledger_out_same_flight(where: str) -> None:
    @examples(25)
    @given(st.lists(records, max_size=4, unique_by=lambda flight: (flight.rocket, flight.flight_id)))
    def law(flights: list[Flight]) -> None:
        with Ledger.open(where) as ledger:
            ledger.remove(*ledger.ids(ledger.flights()))
            ids = ledger.add(flights).new
            assert [ledger.flight(id) for id in ids] == flights
            assert len(ledger.flights()) == len(flights)
            if flights:
                assert ledger.undo().command == "import"
                assert ledger.flights() == []
                ledger.redo()
                assert [ledger.flight(id) for id in ids] == flights

    law()


def test_importing_the_same_flight_twice_changes_nothing(ledger: Ledger) -> None:
    assert ledger.add([FIRST, SECOND]).new == ("1", "2")
    again = ledger.add([FIRST, SECOND])
    assert (again.new, again.duplicates, again.conflicts) == ((), 2, ())
    assert ledger.flights() == [FIRST, SECOND]
    assert len(ledger.history()) == 1


def test_the_same_flight_in_other_units_is_the_same_flight(ledger: Ledger) -> None:
    ledger.add([FIRST])
    there_and_back = 281.3 * (1 + 1e-12)
    assert ledger.add([FIRST.with_changes(apogee=there_and_back)]).duplicates == 1
    assert ledger.flight("1").apogee == 281.3


def test_different_content_under_an_existing_name_is_a_conflict_that_suggests_edit(ledger: Ledger) -> None:
    ledger.add([FIRST])
    added = ledger.add([FIRST.with_changes(apogee=300.0, config="B"), SECOND])
    assert added.new == ("2",)
    (conflict,) = added.conflicts
    assert "config, apogee" in conflict.error
    assert "fieldkit edit" in conflict.error
    assert ledger.flight("1") == FIRST


def test_a_flight_edited_later_is_still_a_duplicate_of_its_row(ledger: Ledger) -> None:
    ledger.add([FIRST])
    ledger.edit("1", apogee=300.0)
    ledger.tag("1", "off_axis")
    ledger.edit("1", flight_id="one")
    assert ledger.add([FIRST]).duplicates == 1
    assert len(ledger.flights()) == 1
    assert ledger.add(ledger.flights()).duplicates == 1
    assert ledger.add([FIRST.with_changes(apogee=301.0)]).new == ("1",)


def test_a_dry_run_says_what_would_happen_and_changes_nothing(ledger: Ledger) -> None:
    ledger.add([FIRST])
    added = ledger.add(
        [IncomingFlight(FIRST, Original.of(b"bytes")), IncomingFlight(SECOND, Original.of(b"bytes"))], dry_run=True
    )
    assert (added.new, added.duplicates) == (("2",), 1)
    assert ledger.flights() == [FIRST]
    assert len(ledger.history()) == 1


def test_a_log_is_one_flight_with_and_without_a_rocket(ledger: Ledger) -> None:
    """If the file names no rocket. A table that names its rockets may use an id for each."""
    log, unnamed = Original.of(b"samples"), FIRST.with_changes(rocket="", flight_id="flight-1")

    def added(rocket: str, *, given: bool = True) -> Added:
        named = {"rocket": rocket} if rocket and given else {}
        return ledger.add([IncomingFlight(unnamed.with_changes(rocket=rocket), log, "a.pf2", given=named)])

    assert added("").new == ("flight-1",)
    (conflict,) = added("Astra").conflicts
    assert "without a rocket; use `fieldkit edit flight-1 rocket=Astra`" in conflict.error
    ledger.edit("flight-1", rocket="Astra")
    assert (added("").duplicates, added("Astra").duplicates) == (1, 1)
    (conflict,) = added("Bob").conflicts
    assert "as a flight of Astra" in conflict.error
    assert added("Bob", given=False).new == ("Bob/flight-1",)


def test_flights_that_are_added_some_at_a_time_are_one_change_and_compared_with_each_other(
    ledger: Ledger, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldkit.ledger.book.MAX_ROWS_BY_NAME", 2)
    other = FIRST.with_changes(rocket="Cirrus")
    added = ledger.add([FIRST, SECOND, other, SECOND, FIRST.with_changes(apogee=270.0), FIRST])
    assert (added.new, added.duplicates, len(added.conflicts)) == (("Astra/1", "2", "Cirrus/1"), 2, 1)
    there = ledger.flights()
    assert len(ledger.history()) == 1
    ledger.undo()
    assert not ledger.flights()
    ledger.redo()
    assert ledger.flights() == there


def test_two_flights_with_one_name_in_a_table_are_a_duplicate_or_a_conflict(ledger: Ledger) -> None:
    added = ledger.add([FIRST, FIRST, FIRST.with_changes(apogee=1.0)])
    assert (len(added.new), added.duplicates, len(added.conflicts)) == (1, 1, 1)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"flight_id": ""}, "an? (empty )?id"),
        ({"apogee": float("nan")}, "apogee_m: found nan"),
        ({"wind": float("inf")}, "wind_mps: found inf"),
        ({"notes": "a\0b"}, "notes"),
        ({"tags": ("\ud800",)}, "tags"),
    ],
)
def test_values_that_a_ledger_cannot_store_are_named_and_the_rest_is_imported(
    ledger: Ledger, change: dict[str, object], found: str
) -> None:
    added = ledger.add([FIRST.with_changes(**change), SECOND])
    assert added.new == ("2",)
    assert re.search(found, added.conflicts[0].error)
    with pytest.raises((LedgerError, BadValue), match=found.split(":")[0]):
        ledger.edit("2", **change)
    assert ledger.flight("2") == SECOND


def test_flights_are_ordered_by_date_then_entry_and_undated_ones_by_entry(ledger: Ledger) -> None:
    undated = SECOND.with_changes(flight_id="0", date_time=None)
    twin = FIRST.with_changes(flight_id="3")
    ledger.add([undated, twin, SECOND, FIRST])
    assert [flight.flight_id for flight in ledger.flights()] == ["0", "3", "1", "2"]
    ledger.add([undated.with_changes(flight_id="4"), undated.with_changes(flight_id="5", rocket="Other")])
    assert [flight.flight_id for flight in ledger.flights()] == ["0", "5", "3", "1", "2", "4"]
    assert [flight.flight_id for flight in ledger.flights(FIRST.rocket)] == ["0", "3", "1", "2", "4"]
    every = ledger.flights()
    assert [ledger.flights(last=count) for count in range(1, 8)] == [every[-count:] for count in range(1, 8)]
    assert ledger.flights("Other", last=1) == ledger.flights("Other")[-1:]


def test_an_id_is_the_flight_id_if_it_is_unique(ledger: Ledger) -> None:
    other = FIRST.with_changes(rocket="Comet")
    assert ledger.add([FIRST, SECOND]).new == ("1", "2")
    assert ledger.add([other]).new == ("Comet/1",)
    assert ledger.ids(ledger.flights()) == ["Astra/1", "Comet/1", "2"]
    assert ledger.flight("Comet/1") == other
    assert ledger.flight("Astra/2") == SECOND
    with pytest.raises(LedgerError, match="1 is ambiguous: Astra/1 or Comet/1"):
        ledger.flight("1")


def test_an_unknown_id_is_refused_with_similar_ones(ledger: Ledger) -> None:
    ledger.add([FIRST.with_changes(flight_id="astra-07"), SECOND])
    with pytest.raises(LedgerError, match="did you mean astra-07"):
        ledger.flight("astra-7")
    with pytest.raises(LedgerError, match="holds 2 flights"):
        ledger.flight("zzzz")


def test_every_kind_of_change_can_be_undone_and_redone(ledger: Ledger) -> None:
    states = [ledger.flights()]

    def then(change: object) -> None:
        states.append(ledger.flights())

    then(ledger.add([FIRST, SECOND]))
    then(ledger.edit("1", apogee=300.0, extra={"a": "b"}, date_time=None))
    then(ledger.edit("1", rocket="Comet", flight_id="7"))
    then(ledger.tag("7", "off_axis"))
    then(ledger.untag("7", "mine", "weak_launch"))
    then(ledger.remove("7", "2"))
    for state in reversed(states[:-1]):
        assert ledger.undo().undone
        assert ledger.flights() == state
    with pytest.raises(LedgerError, match="nothing left to undo"):
        ledger.undo()
    for state in states[1:]:
        ledger.redo()
        assert ledger.flights() == state
    with pytest.raises(LedgerError, match="nothing left to redo"):
        ledger.redo()
    commands = [change.command for change in ledger.history()]
    assert commands == ["import", "edit", "edit", "tag", "untag", "remove", *["undo"] * 6, *["redo"] * 6]


def test_documents_changed_with_flights_are_undone_with_them(ledger: Ledger) -> None:
    ledger.add([FIRST])
    assert ledger.change_draft("plan", {"wind": (1, 2)}, "plan", "Astra")
    assert not ledger.change_draft("plan", {"wind": [1, 2]}, "plan", "Astra"), "it is so already"
    assert ledger.edit_all([], "North field", {"sites": {"North field": {"size": 400.0}}}) == 0
    assert ledger.edit_all(["1"], "North field", {"sites": {"South field": {"size": 400.0}}}, site="South field") == 1
    assert ledger.undo().what == "North field (site, sites)"
    assert ledger.flight("1").site == FIRST.site
    assert ledger.draft("sites") == {"North field": {"size": 400.0}}
    ledger.undo()
    assert ledger.draft("sites") is None
    ledger.undo()
    assert ledger.draft("plan") is None
    for _ in range(3):
        ledger.redo()
    assert ledger.flight("1").site == "South field"
    assert ledger.draft("plan") == {"wind": [1, 2]}
    assert ledger.draft("sites") == {"South field": {"size": 400.0}}


def test_after_an_undo_a_new_change_discards_redo(ledger: Ledger) -> None:
    ledger.add([FIRST])
    ledger.tag("1", "late")
    ledger.undo()
    ledger.tag("1", "later")
    with pytest.raises(LedgerError, match="nothing left to redo"):
        ledger.redo()
    assert [change.undone for change in ledger.history()] == [False, True, False, False]
    ledger.undo()
    ledger.undo()
    assert ledger.flights() == []


def test_a_change_without_effect_is_not_in_the_journal(ledger: Ledger) -> None:
    ledger.add([FIRST])
    ledger.tag("1", "mine")
    ledger.edit("1", apogee=FIRST.apogee)
    ledger.activate("Astra", None)
    ledger.add([])
    assert len(ledger.history()) == 1


def test_an_edit_to_an_existing_name_is_refused(ledger: Ledger) -> None:
    ledger.add([FIRST, SECOND])
    with pytest.raises(LedgerError, match="flight 1 of Astra is already in the ledger"):
        ledger.edit("2", flight_id="1")
    assert ledger.flights() == [FIRST, SECOND]


def test_removing_a_missing_tag_lists_the_tags_of_the_flight(ledger: Ledger) -> None:
    ledger.add([FIRST])
    with pytest.raises(LedgerError, match="it has weak_launch, mine"):
        ledger.untag("1", "damaged")


def test_one_unknown_id_among_several_removes_nothing(ledger: Ledger) -> None:
    ledger.add([FIRST, SECOND])
    with pytest.raises(LedgerError, match="no flight '3'"):
        ledger.remove("1", "3")
    assert len(ledger.flights()) == 2


def test_the_bytes_of_a_log_are_returned_unchanged(ledger: Ledger) -> None:
    ledger.add([IncomingFlight(FIRST, Original.of(b"\0\xff" * 5000))])
    ledger.add([IncomingFlight(SECOND, Original.of(b"two"))])
    assert ledger.log("1") == b"\0\xff" * 5000
    ledger.remove("1")
    ledger.undo()
    assert ledger.log("1") == b"\0\xff" * 5000
    assert ledger.log("2") == b"two"
    ledger.add([FIRST.with_changes(flight_id="3")])
    assert ledger.log("3") is None


def test_the_values_used_last_are_offered_first(ledger: Ledger) -> None:
    assert ledger.latest() is None
    ledger.add([SECOND.with_changes(rocket="Comet", config=""), FIRST])
    assert ledger.names("rocket") == ["Astra", "Comet"]
    assert ledger.names("config") == ["A"]
    assert ledger.names("motor", "Comet") == ["F24-4W"]
    assert ledger.latest() == FIRST
    assert ledger.latest("Comet").flight_id == "2"
    assert ledger.latest("Comet", "A") is None
    assert ledger.next_flight_id("Comet") == "3"
    assert ledger.next_flight_id("New") == "1"


def test_model_versions_are_numbered_by_rocket_and_one_is_in_use(ledger: Ledger) -> None:
    assert ledger.active_version("Astra") is None
    ledger.keep_version("Astra", {"effect": "wind", "sd": 0.1})
    second = ledger.keep_version("Astra", {"effect": "none"}, activate=False)
    assert (second.number, second.active) == (2, False)
    assert ledger.keep_version("Comet", {}).number == 1
    assert ledger.active_version("Astra").payload == {"effect": "wind", "sd": 0.1}
    ledger.activate("Astra", 2)
    assert [version.active for version in ledger.versions("Astra")] == [False, True]
    ledger.activate("Astra", None)
    assert ledger.active_version("Astra") is None
    with pytest.raises(LedgerError, match="no model version 3, expected one of: 0, 1, 2"):
        ledger.activate("Astra", 3)


def test_accepting_a_model_version_can_be_undone(ledger: Ledger) -> None:
    ledger.keep_version("Astra", {"effect": "wind"})
    ledger.keep_version("Astra", {"effect": "mass_offset"})
    ledger.undo()
    assert ledger.active_version("Astra").payload == {"effect": "wind"}
    ledger.activate("Astra", None)
    ledger.undo()
    assert ledger.active_version("Astra").number == 1
    ledger.undo()
    assert ledger.versions("Astra") == []


def test_a_prediction_is_saved_once_and_not_affected_by_undo(ledger: Ledger) -> None:
    ledger.add([FIRST])
    made = ledger.keep_prediction({"p50": 281.0}, digest="d1", rocket="Astra", flight_id="2")
    assert made.at.tzinfo is UTC
    assert ledger.keep_prediction({"p50": 281.0}, digest="d1", rocket="Astra", flight_id="2") == made
    ledger.keep_prediction({"p50": 282.0}, digest="d2", rocket="Astra", flight_id="2")
    ledger.keep_prediction({"p50": 1.0}, digest="d3", rocket="Comet")
    assert [one.payload["p50"] for one in ledger.predictions("Astra")] == [281.0, 282.0]
    assert [one.digest for one in ledger.predictions(flight_id="2")] == ["d1", "d2"]
    ledger.undo()
    assert ledger.flights() == []
    assert len(ledger.predictions()) == 3


def test_a_draft_is_kept_until_it_is_discarded(ledger: Ledger) -> None:
    assert ledger.draft("add") is None
    ledger.keep_draft("add", {"rocket": "Astra"})
    ledger.keep_draft("add", {"rocket": "Astra", "apogee": "923ft"})
    assert ledger.draft("add") == {"rocket": "Astra", "apogee": "923ft"}
    assert ledger.history() == [], "keys are kept beside the journal"
    assert ledger.drop_draft("add")
    assert not ledger.drop_draft("add")
    assert ledger.draft("add") is None
    ledger.undo()
    assert ledger.draft("add") == {"rocket": "Astra", "apogee": "923ft"}
    ledger.redo()
    assert ledger.draft("add") is None


def test_a_flight_that_is_undone_is_a_draft_again_unless_another_was_started(ledger: Ledger) -> None:
    ledger.keep_draft("add", {"rocket": "Astra"})
    ledger.add([FIRST], draft="add")
    assert ledger.draft("add") is None
    ledger.undo()
    assert ledger.draft("add") == {"rocket": "Astra"}
    ledger.redo()
    assert ledger.draft("add") is None
    assert ledger.flights()
    ledger.keep_draft("add", {"rocket": "Comet"})
    ledger.undo()
    assert ledger.draft("add") == {"rocket": "Comet"}
    assert not ledger.flights()


def test_undoing_a_removal_keeps_what_was_known_before_the_flight(ledger: Ledger) -> None:
    ledger.add([FIRST])
    ledger.add([SECOND])
    ledger.remove("1")
    ledger.undo()
    assert ledger.before([FIRST, SECOND])[0].flights == ()
    ledger.redo()
    ledger.undo()
    past = ledger.before([FIRST, SECOND])
    assert [[flight.flight_id for flight in one.flights] for one in past] == [[], ["1"]]


def test_a_renamed_flight_is_a_duplicate_even_if_another_has_its_old_name(ledger: Ledger) -> None:
    ledger.add([FIRST])
    ledger.edit("1", rocket="Vega")
    ledger.add([FIRST.with_changes(apogee=300.0)])
    ledger.edit("Astra/1", notes="another flight")
    again = ledger.add([FIRST])
    assert (again.duplicates, again.conflicts) == (1, ())


def test_a_flight_edited_while_its_files_are_reread_keeps_the_edit(ledger: Ledger) -> None:
    read = Flight(
        "1", "Astra", apogee=100.0, top_speed=40.0, sd={"apogee": 2.0}, extra={"kinds": "raw", "color": "red"}
    )
    again = replace(
        read,
        apogee=101.0,
        top_speed=41.0,
        burn_time=0.9,
        sd={"apogee": 1.0, "burn_time": 0.1},
        extra={"kinds": "raw csv"},
    )
    ledger.add([read])
    ledger.edit("1", notes="high", top_speed=45.0, burn_time=1.2, extra={**read.extra, "color": "blue"})
    edited = ledger.flight("1")
    assert ledger.renew([Renewal("1", read, again)]) == 1
    assert ledger.flight("1") == replace(
        edited, apogee=101.0, sd={"apogee": 1.0}, extra={"kinds": "raw csv", "color": "blue"}
    )
    ledger.undo()
    assert ledger.flight("1") == edited
