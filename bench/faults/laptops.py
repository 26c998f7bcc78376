"""Laptops of a club on one PostgreSQL server: mixed work at once, the server killed and started again below them.

Each laptop is a process that draws its next command, and notes in a file of its own what was acknowledged. At the end
every flight that was added and acknowledged is there once, and none that its own laptop has removed; the journal has
each change once and in order.
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
from bench.faults.servers import Server, emptied
from fieldkit.ledger import Ledger

DOWN = 0.3
"""How long a killed server stays away. [s]"""


def mixed_work(ours: Server, folder: Path, laptops: int, seconds: float, kills: int, seed: int) -> Outcome:
    """Laptops that work for a time on one server, which dies so often in the meantime."""
    outcome = Outcome("PostgreSQL", f"{laptops} laptops, mixed work for {seconds:.0f} s, server killed {kills} times")
    folder.mkdir(parents=True)
    emptied(ours.url)
    assert fieldkit(ours.url, "import", str(TABLE))[0] == 0
    context = multiprocessing.get_context("fork")
    running = [
        context.Process(target=_work, args=(ours.url, folder / f"laptop-{place}.txt", place, seconds, seed + place))
        for place in range(laptops)
    ]
    for process in running:
        process.start()
    with _killing(ours, seconds / (kills + 1), kills):
        for process in running:
            process.join()
    if any(process.exitcode for process in running):
        outcome.faults.append("a laptop's command ended in a traceback")
    return _judged(outcome, ours.url, folder)


@contextmanager
def _killing(ours: Server, every: float, kills: int) -> Iterator[None]:
    """Kill the server so often, and start it again."""
    over = Event()

    def work() -> None:
        for _ in range(kills):
            if over.wait(every):
                return
            ours.kill()
            time.sleep(DOWN)
            ours.start()

    thread = Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _work(url: str, notes: Path, laptop: int, seconds: float, seed: int) -> None:
    """Commands of one laptop until the time is over; `+` and `-` before what is known to be there, and not."""
    rng, ends, mine = random.Random(seed), time.monotonic() + seconds, list[str]()
    with notes.open("a", encoding="ascii") as noted:

        def done(mark: str, *arguments: str) -> bool:
            status = fieldkit(url, *arguments)[0]
            noted.write(f"{'?' if status else ''}{mark}\n")
            noted.flush()
            return not status

        number = 0
        while time.monotonic() < ends:
            number += 1
            _draw(rng, f"L{laptop}-{number}", laptop, mine, done)


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
    else:
        done("", "flights")


def _judged(outcome: Outcome, url: str, folder: Path) -> Outcome:
    """Compare what was acknowledged with what is there. Of what was refused either may be so, once."""
    known: dict[str, bool | None] = {}
    notes = sorted(folder.glob("laptop-*.txt"))
    marks = [line for file in notes for line in file.read_text(encoding="ascii").splitlines()]
    for mark in marks:
        sign = mark.lstrip("?")[:1]
        if sign in {"+", "-"}:
            known[mark.lstrip("?")[1:]] = None if mark.startswith("?") else sign == "+"
    with Ledger.open(url) as ledger:
        held = Counter(flight.flight_id for flight in ledger.flights() if flight.flight_id.startswith("L"))
        numbers = [change.number for change in ledger.history()]
    for id, there in known.items():
        if there is not None and bool(held[id]) != there:
            outcome.faults.append(f"{id} was acknowledged to be {'there' if there else 'gone'}, and is not")
    outcome.faults += [f"{id} is there {count} times" for id, count in held.items() if count > 1]
    outcome.faults += [f"{id} is there, and nobody added it" for id in held if id not in known]
    if numbers != list(range(1, len(numbers) + 1)):
        outcome.faults.append("the journal is out of order")
    refused = sum(mark.startswith("?") for mark in marks)
    outcome.tried = len(marks)
    outcome.counts = {"acknowledged": outcome.tried - refused, "refused while the server was away": refused}
    return outcome
