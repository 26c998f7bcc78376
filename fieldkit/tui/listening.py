"""Connections to the app's server, with a limit in total and a lower limit per address, so that nobody can block
others."""

import asyncio
import signal
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from aiohttp import web

MAX_CONNECTIONS = 100
"""Maximum number of open connections; a browser uses about six. [1]"""
MAX_OF_ADDRESS = 50
"""Maximum number of open connections per address. [1]"""
SHUTDOWN_PERIOD = 5.0
"""Time limit for unfinished responses at the end. [s]"""


class Connections:
    """The open connections, by their source address."""

    def __init__(self) -> None:
        self._open: dict[asyncio.BaseTransport, str] = {}

    def has_room(self, address: str) -> bool:
        """Whether an address may open another connection."""
        self._open = {one: whose for one, whose in self._open.items() if not one.is_closing()}
        whose = list(self._open.values())
        return len(whose) < MAX_CONNECTIONS and whose.count(address) < MAX_OF_ADDRESS

    def came(self, transport: asyncio.BaseTransport, address: str) -> None:
        """Count an accepted connection."""
        self._open[transport] = address

    async def accept(self, listening: socket.socket, server: web.Server) -> None:
        """Accept connections; one beyond the limit is closed immediately, before anything is read."""
        loop = asyncio.get_running_loop()
        while True:
            connection, where = await loop.sock_accept(listening)
            address = str(where[0])
            if not self.has_room(address):
                connection.close()
                continue
            with suppress(OSError):  # already closed by the other side
                transport, _ = await loop.connect_accepted_socket(server, connection)
                self.came(transport, address)


async def serve(app: web.Application, host: str, port: int) -> None:
    """Listen on a host until a signal arrives. Raises OSError if it cannot listen there."""
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=SHUTDOWN_PERIOD)
    await runner.setup()
    try:
        if runner.server is not None:
            with _sockets(host, port) as sockets:
                await _accepted(sockets, runner.server)
    finally:
        await runner.cleanup()


async def _accepted(sockets: list[socket.socket], server: web.Server) -> None:
    """Accept connections until a signal arrives."""
    connections, over = Connections(), asyncio.Event()
    with suppress(NotImplementedError):  # on Windows an interrupt ends the loop
        for one in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(one, over.set)
    waiting = [asyncio.ensure_future(connections.accept(one, server)) for one in sockets]
    ended = asyncio.ensure_future(over.wait())
    done, _ = await asyncio.wait([ended, *waiting], return_when=asyncio.FIRST_COMPLETED)
    for task in (ended, *waiting):
        task.cancel()
    for task in done:
        task.result()


@contextmanager
def _sockets(host: str, port: int) -> Iterator[list[socket.socket]]:
    """Listening sockets for every address of a host."""
    found = dict.fromkeys(
        (family, where[0]) for family, _, _, _, where in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    )
    sockets: list[socket.socket] = []
    try:
        for family, name in found:
            sockets.append(socket.create_server((str(name), port), family=family, backlog=MAX_CONNECTIONS))
            sockets[-1].setblocking(False)
        yield sockets
    finally:
        for one in sockets:
            one.close()
