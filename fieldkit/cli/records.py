"""Flights of the ledger: `flights`, `show`, `edit`, `tag`, `untag` and `remove`."""

from itertools import chain, takewhile
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.compare import document as measured
from fieldkit.cli.completing import flight_ids, rocket_names
from fieldkit.cli.options import takes_flight
from fieldkit.cli.predictions import prediction_of, print_prediction
from fieldkit.cli.screen import AsJson, complain, print_card, print_json, print_table, say, say_wrapped, system
from fieldkit.cli.session import LIFT_OFF, MotorCheck, note_dry_mass, open_ledger, read_settings, split_settings
from fieldkit.cli.stream import stream_json, stream_table
from fieldkit.errors import FieldkitError, LedgerError, nearest, unknown
from fieldkit.flight import BY_NAME, TAGS, read_tags
from fieldkit.flight.event_names import event_title
from fieldkit.flight.plausibility import doubts
from fieldkit.flight.short_name import flight_label
from fieldkit.flight.storable import check_name
from fieldkit.presentation.export import document
from fieldkit.quantities import counted, in_system, measure, significant, with_sd
from fieldkit.services.names import same_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from fieldkit.flight import Flight
    from fieldkit.forecast.one_offs import FlightBesideOthers
    from fieldkit.ledger import FlightSummary, Ledger
    from fieldkit.rocket import Configuration
    from fieldkit.services.replay import Recording

app = typer.Typer()

FLIGHT_HELP = "Its id, as `fieldkit flights` lists it, or the beginning of it, or rocket/id; last: the newest entry."
FlightId = Annotated[
    str,
    typer.Argument(
        metavar="FLIGHT",
        help=FLIGHT_HELP,
        show_default=False,
        autocompletion=flight_ids,
    ),
]
Tags = Annotated[list[str], typer.Argument(metavar="TAG...", help="Tag, such as weak_launch.", show_default=False)]


@app.command()
def flights(
    context: typer.Context,
    rocket: Annotated[
        str | None, typer.Option(help="Flights of this rocket only.", autocompletion=rocket_names)
    ] = None,
    tag: Annotated[str | None, typer.Option(help="Flights with this tag only.")] = None,
    json: AsJson = False,
) -> None:
    """List the flights in the ledger."""
    with open_ledger(context) as ledger:
        if json:
            stream_json("flights", (document(flight) for page in ledger.pages(rocket, tag) for _, flight in page))
            return
        pages = ledger.summaries(rocket, tag)
        if (first := next(pages, None)) is None:
            for note in _mistyped(ledger, rocket, tag):
                complain(f"note: {note}")
            for known in ledger.rocket(rocket).configurations if rocket else ():
                say(_in_words(known))
            complain(f"No matching flights in {ledger.name}" if rocket or tag else f"No flights in {ledger.name} yet")
        else:
            headers = ("id", "date", "rocket", "config", "motor", "apogee", "tags")
            chosen = system()
            rows = ([_listed(one, chosen) for one in page] for page in chain([first], pages))
            stream_table(headers, rows, numbers=["apogee"])


def _in_words(one: "Configuration") -> str:
    """What is known of a configuration apart from its flights."""
    mass = one.dry_mass if one.weighed_mass is None else one.weighed_mass
    diameter = one.diameter if one.measured_diameter is None else one.measured_diameter
    figures = [
        f"dry mass {significant(BY_NAME['dry_mass'], mass, system())}" if mass is not None else "",
        f"diameter {significant(BY_NAME['diameter'], diameter, system())}" if diameter is not None else "",
        f"Cd {one.cd:.2f} of {one.source}" if one.cd else "",
    ]
    return f"{one.rocket} {one.config}".strip() + ": " + ", ".join(filter(None, figures))


def _mistyped(ledger: "Ledger", rocket: str | None, tag: str | None) -> "Iterator[str]":
    """A rocket and a tag that no flight of the ledger has, with the nearest ones."""
    rockets = ledger.names("rocket")
    if rocket is not None and rocket not in rockets:
        yield unknown("rocket", rocket, rockets)
    tags = sorted({one for flight in ledger.flights() for one in flight.tags}) if tag is not None else []
    if tag is not None and tag not in tags:
        yield unknown("flight with the tag", tag, tags)


def _listed(one: "FlightSummary", system: str) -> tuple[str, ...]:
    """A flight as a row of the list, in the units of a system."""
    day = one.day.isoformat() if one.day else ""
    apogee = measure(BY_NAME["apogee"], one.apogee, system)
    return one.id, day, one.rocket, one.config, one.motor, apogee, "; ".join(one.tags)


@app.command()
def show(context: typer.Context, flight: FlightId, json: AsJson = False) -> None:
    """Show everything recorded about a flight."""
    with open_ledger(context) as ledger:
        found = ledger.flight(flight)
        (id,) = ledger.ids([found])
        recording = _recording(ledger, flight) if found.has_log else None
        forecast = prediction_of(ledger, found)
        beside = _beside_others(ledger, found)
        excluded = _exclusion(found)
    if json:
        from fieldkit.presentation.json_documents import flight_document

        print_json(
            document(found)
            | ({"recording": measured(recording)} if recording else {})
            | ({"prediction": forecast.json()} if forecast else {})
            | (flight_document(beside) if beside else {})
        )
        return
    print_card(found, id)
    print_prediction(forecast)
    if excluded:
        say_wrapped(f"Excluded from every fit: {excluded}.")
    if beside:
        from fieldkit.presentation.one_off_text import why

        say_wrapped(why(beside, system()))
    if recording:
        _print_events(recording)
        if _measures_otherwise(found, recording):
            complain(
                "note: this version measures the log differently, either way: "
                f"`fieldkit remeasure {quote(id)} --dry-run` shows by how much, and without --dry-run updates the "
                "flight"
            )


def _exclusion(flight: "Flight") -> str:
    """Why a flight without tags is excluded from every fit; empty if it is used."""
    from fieldkit.services.plausible_flights import exclusion

    return in_system(exclusion(flight, MotorCheck().catalogue), system()) if flight.clean else ""


def _beside_others(ledger: "Ledger", flight: "Flight") -> "FlightBesideOthers | None":
    """A flight beside the others of its rocket; None if it cannot be simulated. Raises LedgerError for a damaged
    ledger: without the others' figures the answer would be another one."""
    from fieldkit.services.one_offs import flight_beside_others

    try:
        return flight_beside_others(ledger, MotorCheck().catalogue, flight)
    except LedgerError:
        raise
    except FieldkitError:
        return None


def _recording(ledger: "Ledger", id: str) -> "Recording | None":
    """The samples of a flight; None if they cannot be read again, and the card is printed without them."""
    from fieldkit.services.replay import recording_of

    try:
        return recording_of(ledger, id)
    except FieldkitError as error:
        complain(f"note: {error}")
        return None


def _measures_otherwise(flight: "Flight", recording: "Recording") -> bool:
    """Whether a figure from a log is measured differently by this version, beyond rounding."""
    figures = {name: figure.value for name, figure in recording.recorded.figures.items() if name in BY_NAME}
    read = flight.readouts()
    measured = {n: read[n] for n in figures if n in read and n in flight.sd and flight.source.get(n) != "typed"}
    return any(abs(value - figures[name]) > 0.001 for name, value in measured.items())


def _print_events(recording: "Recording") -> None:
    """Print events on the log's clock, and the source of each figure."""
    from fieldkit.analysis.labels import TITLES, figure_text

    recorded = recording.recorded
    if recorded.events:
        say()
        rows = [
            (event_title(name), f"{with_sd(one.time, one.sd)} s", one.source) for name, one in recorded.events.items()
        ]
        print_table(("event", "on the log's clock", "by"), rows)
    if recorded.figures:
        say()
        figures = [
            (TITLES[n], figure_text(n, f.value, f.sd, system()), f.source)
            for n in TITLES
            if (f := recorded.figures.get(n))
        ]
        print_table(("measured", "", "by"), figures)
    for note in recorded.notes:
        complain(f"note: {in_system(note, system())}")


def edit(
    context: typer.Context,
    flight: FlightId,
    changes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FLIGHT...] COLUMN=VALUE...",
            help="More flights, and apogee=923ft; an empty value clears: notes=.",
            show_default=False,
        ),
    ] = None,
    **given: str | None,
) -> None:
    """Change columns of a flight, of several, or of all flights of a rocket, for which its name stands.

    The options of `fieldkit add` change them too: --apogee 923ft. A readout also has a standard deviation and a source:
    apogee_sd_m=2, apogee_source=gps.
    lift_off_mass=620g is the mass weighed with the motor, from which the dry mass follows.
    timer_1_s=38.42 and timer_2_s are what two watches showed, eggs="2 intact" how a contest flight was judged.
    Lark rocket=Comet renames a rocket, and the correction of the loop goes with it; a flight whose id the other rocket
    has gets its next free number.
    """
    from fieldkit.services.renaming import edit_flights

    changes = changes or []
    options = {name: text for name, text in given.items() if text is not None}
    more = list(takewhile(lambda one: "=" not in one, changes))
    if not options and len(more) == len(changes):
        raise typer.BadParameter(f"found {more[-1]!r}, expected COLUMN=VALUE" if more else "expected COLUMN=VALUE")
    settings = split_settings(changes[len(more) :])
    if both := ", ".join(settings.keys() & options.keys()):
        raise typer.BadParameter(f"found {both} twice, expected one value")
    settings |= options
    motors = MotorCheck()
    with open_ledger(context) as ledger:
        before = [ledger.flight(id) for id in ledger.ids_meant([flight, *more])]
        own = [_changed(ledger, motors, one, settings) for one in before]
        _note_unknown_names(ledger, before, own)
        done = edit_flights(ledger, before, own)
        for note in done.notes:
            complain(f"note: {note}")
        names = [flight_label(id) for id in ledger.ids(done.flights)]
        if {*BY_NAME, "motor"} & set(chain(*own)):
            _remark_changes(ledger, motors, before, done.flights)
    if LIFT_OFF in settings:
        for one in done.flights:
            note_dry_mass(one)
    named = names[0] if len(names) == 1 else counted(done.count or len(names), "flight")
    say(f"Changed {named}. `fieldkit undo` to undo." if done.count else f"{named[0].upper()}{named[1:]} unchanged")


takes_flight(edit, hidden=True)
app.command()(edit)


def _changed(
    ledger: "Ledger", motors: MotorCheck, flight: "Flight", settings: "Mapping[str, str]"
) -> dict[str, object]:
    """The fields of a flight that settings change; what follows from another rocket or configuration is printed."""
    from fieldkit.motors.several import tagged
    from fieldkit.services.manual_entry import as_built

    changed = read_settings(settings, motors, flight)
    if (rocket := str(changed.get("rocket") or "")) and rocket.casefold() != flight.rocket.casefold():
        changed["rocket"] = same_name(rocket, ledger.names("rocket"))
    if "motor" in changed:
        changed = {"tags": tagged(flight.with_changes(**changed)).tags} | changed
    if changed.keys() & {"rocket", "config"}:
        built, notes = as_built(ledger, flight.with_changes(**changed), changed)
        changed |= {name: getattr(built, name) for note in notes for name in note.columns}
        for note in notes:
            complain(f"note: {in_system(note.text, system())}; edit to change")
    return changed


def _note_unknown_names(
    ledger: "Ledger", before: "Sequence[Flight]", changed: "Sequence[Mapping[str, object]]"
) -> None:
    """Print a note for each new name of a flight that looks like a misspelled known one, except one that no other
    flight has."""
    from fieldkit.services.unknown_names import unknown_names

    others = [one for rocket in {one.rocket for one in before} for one in ledger.flights(rocket) if one not in before]
    former = {name for one in before for name in (one.rocket, one.config, one.site)}
    former -= {name for one in others for name in (one.rocket, one.config)}
    notes = [
        note
        for one, values in zip(before, changed, strict=True)
        for note in unknown_names(ledger, one.with_changes(**values), values, new=True, former=former)
    ]
    for note in dict.fromkeys(notes):
        complain(f"note: {note}")


def _remark_changes(
    ledger: "Ledger", motors: MotorCheck, before: "Sequence[Flight]", after: "Sequence[Flight]"
) -> None:
    """Remark on what looks mistyped in changed flights or is excluded from every fit, and was not so before."""
    from fieldkit.services.manual_entry import usual
    from fieldkit.services.plausible_flights import exclusions

    known = {*exclusions(before, motors.catalogue), *(doubt for one in before for doubt in doubts(one))}
    found = [doubt for one in after for doubt in doubts(one, usual(ledger, motors.catalogue, one))]
    ledger.remark(*(one for one in [*exclusions(after, motors.catalogue), *found] if one not in known))


@app.command()
def tag(context: typer.Context, flight: FlightId, tags: Tags) -> None:
    """Add tags to a flight; a flight tagged as an anomaly is not used in the model."""
    named = [check_name(one) for one in read_tags(";".join(tags))]
    for own in named:
        if own not in TAGS and nearest(own, TAGS):
            complain(f"note: {unknown('known tag', own, TAGS)}")
    with open_ledger(context) as ledger:
        _say_tags(ledger, ledger.flight(flight), ledger.tag(flight, *named))


@app.command()
def untag(context: typer.Context, flight: FlightId, tags: Tags) -> None:
    """Remove tags from a flight."""
    with open_ledger(context) as ledger:
        _say_tags(ledger, ledger.flight(flight), ledger.untag(flight, *read_tags(";".join(tags))))


def _say_tags(ledger: "Ledger", before: "Flight", flight: "Flight") -> None:
    """Print the tags of a flight, whether a change of them decides about its use, and how to undo it."""
    (id,), after = ledger.ids([flight]), flight.tags
    tags = (
        f"has the tags {'; '.join(after)}" if len(after) > 1 else f"has the tag {after[0]}" if after else "has no tags"
    )
    if before.clean != flight.clean:
        tags += ", and is used in forecasts again" if flight.clean else ", and is not used in forecasts"
    say(f"{flight_label(id, 'Flight')} {tags}" + (". `fieldkit undo` to undo." if before.tags != after else ""))


@app.command()
def remove(
    context: typer.Context,
    flights: Annotated[
        list[str],
        typer.Argument(
            metavar="FLIGHT...",
            help=FLIGHT_HELP,
            show_default=False,
            autocompletion=flight_ids,
        ),
    ],
) -> None:
    """Remove flights from the ledger, or all of a rocket, for which its name stands. Can be undone."""
    with open_ledger(context) as ledger:
        ids = ledger.ids([ledger.flight(id) for id in ledger.ids_meant(flights)])
        gone = ledger.remove(*ids)
    named = flight_label(ids[0]) if len(gone) == 1 else counted(len(gone), "flight")
    say(f"Removed {named}. `fieldkit undo` to undo.")
