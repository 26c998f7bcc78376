"""Damaged files: truncated and with flipped bits, at random positions."""

import random
import shutil
from pathlib import Path

from bench.faults.ledgers import Outcome, fieldkit, put, season
from fieldkit.ledger.backups import folder_of

DAMAGE_MESSAGES = (
    "the file is damaged",
    "is not a ledger",
    "the file is empty",
    "holds another program's tables",
)
ASKED = (("flights", "--json"), ("history", "--json"), ("show", "2", "--json"))
"""Commands run on a damaged ledger, which read all tables that a user sees."""


def cut_short(folder: Path, trials: int, seed: int) -> Outcome:
    """Truncate a ledger at random lengths, never its full length."""
    outcome, rng = Outcome("damage", "file cut short"), random.Random(seed)
    template, file, right = _ledger(folder)
    whole = template.read_bytes()
    lengths = [0, 1, 99, 100, 512, 4095, 4096, *(rng.randrange(len(whole)) for _ in range(trials))][:trials]
    for length in lengths:
        _try(outcome, template, file, right, whole[:length], f"cut at {length}")
    return outcome


def bits_flipped(folder: Path, trials: int, seed: int) -> Outcome:
    """Flip one to eight bits anywhere in a ledger."""
    outcome, rng = Outcome("damage", "bits flipped"), random.Random(seed)
    template, file, right = _ledger(folder)
    whole = template.read_bytes()
    for _ in range(trials):
        hurt = bytearray(whole)
        places = [rng.randrange(8 * len(hurt)) for _ in range(rng.choice((1, 2, 8)))]
        for place in places:
            hurt[place // 8] ^= 1 << place % 8
        _try(outcome, template, file, right, bytes(hurt), f"bits {places}")
    return outcome


def _ledger(folder: Path) -> tuple[Path, Path, list[str]]:
    """A sound ledger with a backup, the file to be damaged, and the expected output."""
    folder.mkdir(parents=True, exist_ok=True)
    template, file = folder / "template.db", folder / "ledger.db"
    season(file)
    assert fieldkit(file, "tag", "3", "mine")[0] == 0  # the backup is made before this change
    right = [fieldkit(file, *one)[1] for one in ASKED]
    file.replace(template)
    shutil.copytree(folder_of(file), folder_of(template))
    return template, file, right


def _fresh(template: Path, file: Path) -> None:
    """Restore the sound ledger and its backup, and delete files of an earlier trial."""
    put(template, file)
    for aside in file.parent.glob(f"{file.name}.damaged*"):
        aside.unlink()
    shutil.rmtree(folder_of(file), ignore_errors=True)
    shutil.copytree(folder_of(template), folder_of(file))


def _try(outcome: Outcome, template: Path, file: Path, right: list[str], content: bytes, what: str) -> None:
    """Run commands on a damaged file, which must answer correctly or report the damage and offer the backup; restore
    it.
    """
    _fresh(template, file)
    file.write_bytes(content)
    came, faults = [], []
    for arguments, answer in zip(ASKED, right, strict=True):
        try:
            status, out, message = fieldkit(file, *arguments)
        except Exception as error:  # a traceback in a user's terminal
            faults.append(f"{what}: {arguments[0]} raised {type(error).__name__}: {error}")
            continue
        if status:
            known = any(one in message for one in DAMAGE_MESSAGES) and "fieldkit backups restore" in message
            came.append("reported, backup offered")
            faults += [] if known else [f"{what}: {arguments[0]} said {message.strip()!r}"]
        elif out == answer:
            came.append("answers are right")
        else:
            came.append("another answer")
            faults.append(f"{what}: {arguments[0]} gave another answer and said nothing")
    if file.read_bytes() != content:
        faults.append(f"{what}: the damaged file was written to")
    if any(one != "answers are right" for one in came):
        faults += _restored(file, right)
    outcome.saw(min(came, key=WORST.index, default="raised"), "; ".join(faults[:1]))


WORST = ("another answer", "reported, backup offered", "answers are right")


def _restored(file: Path, right: list[str]) -> list[str]:
    """A message if a restore does not bring the flights back, except for changes after the backup."""
    status, _, message = fieldkit(file, "backups", "restore", "1", "--yes")
    if status:
        return [f"restore said {message.strip()!r}"]
    found = fieldkit(file, "show", "2", "--json")[1]
    return [] if found == right[2] else ["a restored ledger shows another flight 2"]
