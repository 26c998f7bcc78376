"""Laptops of a club on one PostgreSQL server: concurrent mixed work while the server is killed.

The server is restarted, or a standby replaces it for good. Each laptop is a process that draws its next command, and
records acknowledged commands in its own file. At the end every flight that was added and acknowledged is there once,
except those that its own laptop removed; so is every site, and the journal has each change once and in order.
"""

import multiprocessing
import random
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread

from bench.faults.ledgers import TABLE, Outcome, fieldkit
from bench.faults.servers import Server, emptied, standby
from fieldkit.ledger import Ledger
from fieldkit.services.sites import SITES

EVERY = 15.0
"""Interval between commands of a laptop at a club's pace. [s]"""
HOUR = round(3600 / EVERY)
"""Number of commands of a laptop per hour. [1]"""
DOWN = 0.3
"""How long a killed server stays down. [s]"""
STEP = 0.05
"""Polling interval for the progress of the laptops. [s]"""


def mixed_work(
    ours: Server, folder: Path, laptops: int, commands: int, kills: int, seed: int, every: float = 0.0
) -> Outcome:
    """Laptops that each run `commands` commands on one server, which is killed and restarted `kills` times meanwhile.

    `every` is the interval between commands, 0 for as fast as possible. [s]
    """

    def kill(_: int) -> None:
        ours.kill()
        time.sleep(DOWN)
        ours.start()

    began = time.monotonic()
    outcome = Outcome("PostgreSQL", "")
    _worked(outcome, (ours.url, ours.url), folder, laptops, commands, kills, kill, seed, every)
    spent = duration(time.monotonic() - began)
    outcome.case = f"{laptops} laptops for {spent}, {commands} commands each, the server killed {kills} times"
    return outcome


def duration(seconds: float) -> str:
    """A duration for people: in seconds below two minutes, in minutes above."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def failed_over(ours: Server, folder: Path, laptops: int, commands: int, seed: int) -> Outcome:
    """Mixed work if the killed server does not return: a standby replaces it, and laptops know both addresses."""
    what = f"{laptops} laptops, {commands} commands each, a standby takes the server's place"
    with standby(ours, folder.with_name(f"{folder.name}-standby")) as other:
        places = f"host=127.0.0.1,127.0.0.1&port={ours.port},{other.port}&target_session_attrs=read-write"
        urls = (ours.url, f"postgresql://postgres@/postgres?{places}")

        def kill(_: int) -> None:
            ours.kill()
            time.sleep(DOWN)
            other.promote()

        try:
            return _worked(Outcome("PostgreSQL", what), urls, folder, laptops, commands, 1, kill, seed)
        finally:
            ours.start()


def _worked(
    outcome: Outcome,
    urls: tuple[str, str],
    folder: Path,
    laptops: int,
    commands: int,
    kills: int,
    kill: Callable[[int], object],
    seed: int,
    every: float = 0.0,
) -> Outcome:
    """Run laptops while a server is killed; `urls` are the URL of that server, and the URL that the laptops use."""
    folder.mkdir(parents=True)
    emptied(urls[0])
    assert fieldkit(urls[0], "import", str(TABLE))[0] == 0
    context = multiprocessing.get_context("fork")
    running = [
        context.Process(
            target=_work,
            args=(urls[1], folder / f"laptop-{place}.txt", place, commands, seed + place, every),
            daemon=True,  # it ends with the bench
        )
        for place in range(laptops)
    ]
    for process in running:
        process.start()
    with _killing(folder, laptops * commands, kills, kill):
        for process in running:
            process.join()
    if any(process.exitcode for process in running):
        outcome.faults.append("a laptop's command ended in a traceback")
    return _judged(outcome, urls[1], folder)


@contextmanager
def _killing(folder: Path, commands: int, kills: int, kill: Callable[[int], object]) -> Iterator[None]:
    """Kill the server `kills` times, spread evenly over the commands; outstanding kills happen at the end."""
    over = Event()

    def work() -> None:
        for place in range(kills):
            while len(_marks(folder)) < commands * (place + 1) / (kills + 1) and not over.wait(STEP):
                pass
            kill(place)

    thread = Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _work(url: str, notes: Path, laptop: int, commands: int, seed: int, every: float) -> None:
    """The commands of one laptop; flights known to be added are recorded with `+`, removed ones with `-`, and sites
    with `*`."""
    rng, mine = random.Random(seed), list[str]()
    with notes.open("a", encoding="ascii") as noted:

        def done(mark: str, *arguments: str) -> bool:
            status = fieldkit(url, *arguments)[0]
            noted.write(f"{'?' if status else ''}{mark}\n")
            noted.flush()
            if status:
                time.sleep(DOWN)  # like a user who reads that the server is down
            return not status

        began = time.monotonic()
        for number in range(commands):
            time.sleep(max(0.0, began + every * (number + rng.random()) - time.monotonic()))
            _draw(rng, f"L{laptop}-{number}", laptop, mine, done)


def _marks(folder: Path) -> list[str]:
    """All records of all laptops so far."""
    notes = sorted(folder.glob("laptop-*.txt"))
    return [line for file in notes for line in file.read_text(encoding="ascii").splitlines()]


def _draw(rng: random.Random, id: str, laptop: int, mine: list[str], done: Callable[..., bool]) -> None:
    draw = rng.random()
    if draw < 0.5 or not mine:
        if done(f"+{id}", "add", "--rocket", f"R{laptop}", "--flight-id", id, "--apogee", "100m"):
            mine.append(id)
    elif draw < 0.65:
        done("", "edit", rng.choice(mine), f"apogee={rng.randrange(80, 300)}m")
    elif draw < 0.8:
        done("", "tag", rng.choice(mine), f"mine{rng.randrange(9)}")
    elif draw < 0.9:
        id = mine.pop(rng.randrange(len(mine)))
        done(f"-{id}", "remove", id)
    elif draw < 0.92:
        done("", "import", str(TABLE))
    elif draw < 0.94:
        done(f"*{id}", "sites", id, "--elevation", "212m")
    elif draw < 0.96:
        done("", "predict", "--rocket", f"R{laptop}", "--motor", "F24-4W", "--dry-mass", "322g", "--diameter", "66mm")
    else:
        done("", "flights")


def _judged(outcome: Outcome, url: str, folder: Path) -> Outcome:
    """Compare the acknowledged changes with the ledger. A refused change may be there or not, but at most once."""
    known: dict[str, bool | None] = {}
    marks = _marks(folder)
    for mark in marks:
        sign = mark.lstrip("?")[:1]
        if sign in {"+", "-"}:
            known[mark.lstrip("?")[1:]] = None if mark.startswith("?") else sign == "+"
    with Ledger.open(url) as ledger:
        stored = Counter(flight.flight_id for flight in ledger.flights() if flight.flight_id.startswith("L"))
        numbers = [change.number for change in ledger.history()]
        sites = ledger.draft(SITES) or {}
    lost = [mark[1:] for mark in marks if mark.startswith("*") and mark[1:] not in sites]
    outcome.faults += [f"the site {id} was acknowledged and is gone" for id in lost]
    for id, there in known.items():
        if there is not None and bool(stored[id]) != there:
            outcome.faults.append(f"{id} was acknowledged to be {'there' if there else 'gone'}, and is not")
    outcome.faults += [f"{id} is there {count} times" for id, count in stored.items() if count > 1]
    outcome.faults += [f"{id} is there, and nobody added it" for id in stored if id not in known]
    if numbers != list(range(1, len(numbers) + 1)):
        outcome.faults.append("the journal is out of order")
    refused = sum(mark.startswith("?") for mark in marks)
    outcome.tried = len(marks)
    outcome.counts = {"acknowledged": outcome.tried - refused, "refused while the server was away": refused}
    return outcome
