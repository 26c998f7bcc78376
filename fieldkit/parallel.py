"""Resumable parallel jobs: each result is saved in a folder as it comes, so that an interrupted job continues.

Workers are Dask's, the extra `cluster`: processes of this computer, or those of a scheduler on as many machines as
there are. The piece of a worker that is lost goes to another one. A scheduler runs whatever reaches it: it belongs on
a network of friends, or behind the keys that Dask can be given. Any other executor does as well.
"""

import os
import re
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import TypeVar

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.files import replace

Item = TypeVar("Item")
PATIENCE = 20.0
"""How long a scheduler may take to answer. [s]"""
_LOCAL_ADDRESS = re.compile(r"local(?::(\d{1,3}))?")


@contextmanager
def workers(where: str) -> Iterator[Executor]:
    """Workers: `local` or `local:4` for so many processes of this computer, else those of the scheduler at an address.

    Raises FieldkitError if Dask is not installed or nobody answers, BadValue for no workers.
    """
    try:
        from distributed import Client, LocalCluster
    except ModuleNotFoundError as error:
        raise FieldkitError("a cluster needs distributed: pip install 'fieldkit[cluster]'") from error
    if not (here := _LOCAL_ADDRESS.fullmatch(where)):
        try:
            client = Client(where, timeout=PATIENCE)
        except (OSError, ValueError) as error:
            raise FieldkitError(f"{where}: no Dask scheduler answers ({' '.join(str(error).split())})") from error
        with client:
            yield client.get_executor(pure=False)
        return
    count = int(here[1] or os.cpu_count() or 1)
    if not count:
        raise BadValue(f"found {where}, expected at least one worker")
    own = LocalCluster(n_workers=count, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
    with own, Client(own) as client:
        yield client.get_executor(pure=False)


def processes(count: int) -> Executor:
    """So many processes of this computer, none of which outlives this one: those of the standard library's pool alone
    wait for ever where the process that began them is killed."""
    from concurrent.futures import ProcessPoolExecutor

    return ProcessPoolExecutor(count, initializer=_end_with_parent)


def _end_with_parent() -> None:
    """End this process as soon as the one that began it has ended."""
    from multiprocessing import connection, parent_process

    if (parent := parent_process()) is None:
        return

    def wait() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    Thread(target=wait, name="parent", daemon=True).start()


def done(
    work: Callable[[Item], bytes], items: Mapping[str, Item], folder: Path, pool: Executor
) -> Iterator[tuple[str, bytes]]:
    """The name and the result of each item as it comes, those first that an earlier run left in the folder.

    Names are names of files. What a piece of work raises is raised here; what came before it is kept.
    """
    folder.mkdir(parents=True, exist_ok=True)
    there = [name for name in items if (folder / name).exists()]
    waiting = {pool.submit(work, item): name for name, item in items.items() if name not in there}
    try:
        yield from ((name, (folder / name).read_bytes()) for name in there)
        for future in as_completed(waiting):
            result = future.result()
            replace(folder / waiting[future], result)
            yield waiting[future], result
    finally:
        for future in waiting:
            future.cancel()
