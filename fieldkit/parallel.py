"""Resumable parallel jobs: each result is saved in a folder as soon as it is done, so that an interrupted job can
continue.

Workers are Dask's, from the extra `cluster`: processes of this computer, or a scheduler's on any number of machines. If
a worker is lost, another one repeats its item. A scheduler runs whatever code it receives: use it only on a trusted
network or with Dask's security keys. Any other executor works too.
"""

import os
import re
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from pathlib import Path
from signal import SIGTERM, raise_signal
from threading import Thread
from typing import TypeVar

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.files import replace

Item = TypeVar("Item")
PATIENCE = 20.0
"""Time limit for a scheduler's answer. [s]"""
_LOCAL_ADDRESS = re.compile(r"local(?::(\d{1,3}))?")


@contextmanager
def workers(where: str) -> Iterator[Executor]:
    """Workers: `local` or `local:4` for processes of this computer, or else those of the scheduler at an address.

    Raises FieldkitError if Dask is not installed or the scheduler does not answer, BadValue for zero workers.
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
    """A pool of processes that end with this one: processes of the standard library's pool wait forever if their parent
    is killed (an import of logs would leave one of 90 MB on each core)."""
    from concurrent.futures import ProcessPoolExecutor  # takes 25 ms to import

    return ProcessPoolExecutor(count, initializer=_end_with_parent)


def _end_with_parent() -> None:
    """Terminate this process as soon as its parent has ended."""
    from multiprocessing import connection, parent_process  # a worker has imported it

    if (parent := parent_process()) is None:
        return

    def wait() -> None:
        connection.wait([parent.sentinel])
        raise_signal(SIGTERM)

    Thread(target=wait, name="parent", daemon=True).start()


def done(
    work: Callable[[Item], bytes], items: Mapping[str, Item], folder: Path, pool: Executor
) -> Iterator[tuple[str, bytes]]:
    """The name and result of each item when it is done, saved results of an earlier run first.

    Names are file names. An exception in an item is raised here; earlier results stay saved.
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
