"""Pure functions of the engine, cached for tests that call them repeatedly with equal arguments."""

import pickle
from collections.abc import Callable
from hashlib import blake2b
from typing import Any


def once(work: Callable[..., Any], asked: Callable[..., object] = lambda *all, **named: (all, named)) -> Any:
    """A cached function, so that results are not computed again for every test.

    `asked` returns the key from the arguments, by default all of them. Results are shared and must not be changed.
    """
    answers: dict[bytes, Any] = {}

    def answer(*all: Any, **named: Any) -> Any:
        key = blake2b(pickle.dumps(asked(*all, **named))).digest()
        if key not in answers:
            answers[key] = work(*all, **named)
        return answers[key]

    return answer
