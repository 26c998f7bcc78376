"""`fieldkit flyer`: the flyer's card, from which planning starts."""

from dataclasses import asdict, replace
from typing import Annotated

import typer

from fieldkit.cli.planning import check_rules
from fieldkit.cli.screen import AsJson, complain, print_json, say, say_wrapped, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.errors import BadValue
from fieldkit.quantities import ShownUnits
from fieldkit.settings import BoxedMotors, Settings, change_settings, read_settings

app = typer.Typer()
NOT_GIVEN = "not given"


@app.command()
def flyer(
    context: typer.Context,
    certification: Annotated[str | None, typer.Option(help="Level of high-power certification: none, 1, 2, 3.")] = None,
    born: Annotated[str | None, typer.Option(help="Year or date of birth: 2009, 2009-05-31.")] = None,
    rules: Annotated[str | None, typer.Option(help="Rules of sites without their own: NAR,FAA or UKRA.")] = None,
    rails: Annotated[str | None, typer.Option(help="Lengths of your rods and rails: 3ft,1.8m.")] = None,
    motor: Annotated[str | None, typer.Option(help="A motor that you counted in your range box: C6-5.")] = None,
    count: Annotated[int | None, typer.Option(min=0, help="How many of --motor there are; 0 takes it out.")] = None,
    lot: Annotated[str, typer.Option(help="Lot or date printed on --motor.")] = "",
    json: AsJson = False,
) -> None:
    """Show or change your card: certification, age, rules, rods and rails, and the motors in your range box.

    Safety checks use certification and age, plans the rules and the longest rail, and `motors --fit ROCKET --box` lists
    only motors in the box. A flight that was flown after its motors were counted takes them out of the box, and undoing
    or removing it puts them back. The units are set by `fieldkit units`.
    """
    if (motor is None) != (count is None):
        raise typer.BadParameter("found --motor or --count alone, expected both: --motor C6-5 --count 3")
    from fieldkit.services.flyer_card import read_card
    from fieldkit.services.range_box import box_left, counted_now

    now = read_settings()
    card = now.flyer
    for name, text in (("certification", certification), ("born", born), ("rails", rails)):
        if text is not None:
            try:
                card = replace(card, **{name: read_card(name, text)})  # type: ignore[arg-type]
            except BadValue as error:
                raise typer.BadParameter(f"--{name}: {error}") from error
    if motor is not None and count is not None:
        known_motors().resolve(motor)
        card = card.with_motors(counted_now(BoxedMotors(motor.strip(), count, lot)))
    if rules:
        check_rules(rules)
    changes = ({"flyer": card} if card != now.flyer else {}) | ({} if rules is None else {"rules": rules})
    if changes:
        now = change_settings(changes)
    left = now.flyer.box
    if left:
        with open_ledger(context) as ledger:
            left = box_left(left, ledger, known_motors())
    if json:
        card = replace(now.flyer, box=left)
        print_json({"rules": now.rules, "units": now.units, **asdict(card), "age": card.age()})
        return
    _print(now, left)


def _print(settings: Settings, left: tuple[BoxedMotors, ...]) -> None:
    card, shown = settings.flyer, ShownUnits(system())
    level = {None: NOT_GIVEN, 0: "none"}.get(card.certification, f"level {card.certification}")
    age = card.age()
    say(f"certification  {level}")
    say(f"age            {NOT_GIVEN if age is None else age}")
    say(f"rules          {settings.rules or 'NAR, FAA (default)'}")
    say(f"units          {settings.units}")
    say_wrapped(f"rails          {', '.join(shown.length(one, 1) for one in card.rails) or NOT_GIVEN}", " " * 15)
    if not card.box:
        complain("No motors in the box; `fieldkit flyer --motor C6-5 --count 3` puts some in")
    for counted, one in zip(card.box, left, strict=True):
        flown = counted.count - one.count
        since = f" ({counted.count} counted on {one.counted[:10]}, {flown} flown since)" if flown else ""
        say(f"box            {one.count} x {one.motor}{f', lot {one.lot}' if one.lot else ''}{since}")
