"""Connections to the app's server, with a limit in total and a lower limit per address, so that few can hardly
block others."""

import asyncio
import signal
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial

from aiohttp import web

MAX_CONNECTIONS = 100
"""Maximum number of open connections; a browser uses about six. [1]"""
IDLE_PERIOD = 15.0
"""How long a connection stays open without a request. [s]"""
PAUSE = 0.1
"""Time before accepting again after a connection that could not be accepted. [s]"""
SHUTDOWN_PERIOD = 5.0
"""Time limit for unfinished responses at the end. [s]"""


class Connections:
    """The open connections, by their source address."""

    def __init__(self) -> None:
        self._open: dict[asyncio.BaseTransport, str] = {}

    def has_room(self, address: str) -> bool:
        """Whether an address may open another connection: while it has fewer than are free, so the first has at most
        half of all, the next a quarter, and a new one still finds a place."""
        self._open = {one: whose for one, whose in self._open.items() if not one.is_closing()}
        whose = list(self._open.values())
        return whose.count(address) < MAX_CONNECTIONS - len(whose)

    def came(self, transport: asyncio.BaseTransport, address: str) -> None:
        """Count an accepted connection."""
        self._open[transport] = address

    async def accept(self, listening: socket.socket, handler: Callable[[], asyncio.Protocol]) -> None:
        """Accept connections; one beyond the limit is closed immediately, before anything is read."""
        loop = asyncio.get_running_loop()
        while True:
            try:
                connection, where = await loop.sock_accept(listening)
            except OSError:  # closed again before it was accepted, or no file is free for it
                await asyncio.sleep(PAUSE)
                continue
            address = str(where[0])
            if not self.has_room(address):
                connection.close()
                continue
            with suppress(OSError):  # already closed by the other side
                transport, _ = await loop.connect_accepted_socket(handler, connection)
                self.came(transport, address)


class Handler(web.RequestHandler):  # type: ignore[misc]  # mypy does not read aiohttp
    """The requests of one connection, which is closed if none arrives; a malformed one, which no middleware sees, is
    answered with the same headers and without echoing it."""

    def __init__(self, server: web.Server, headers: Mapping[str, str]) -> None:
        super().__init__(server, loop=asyncio.get_running_loop(), access_log=None, keepalive_timeout=IDLE_PERIOD)
        self._headers = headers
        self.has_asked = False
        """Whether a whole request has arrived."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start a connection, which is closed after `IDLE_PERIOD` without a request."""
        super().connection_made(transport)
        asyncio.get_running_loop().call_later(IDLE_PERIOD, self._end_silent, transport)

    def _end_silent(self, transport: asyncio.BaseTransport) -> None:
        if not self.has_asked:
            transport.close()

    def handle_error(
        self, request: web.BaseRequest, status: int = 500, exc: BaseException | None = None, message: str | None = None
    ) -> web.StreamResponse:
        """The answer to a malformed request, or to one that failed."""
        super().handle_error(request, status, exc, message)
        answer = web.Response(status=status, text="malformed request" if status < 500 else "failed")
        answer.headers.update(self._headers)
        answer.force_close()
        return answer


async def serve(app: web.Application, host: str, port: int, headers: Mapping[str, str]) -> None:
    """Listen on a host until a signal arrives; `headers` are those of refusals before any middleware.

    Raises OSError if it cannot listen there.
    """
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=SHUTDOWN_PERIOD)
    await runner.setup()
    try:
        if runner.server is not None:
            with _sockets(host, port) as sockets:
                await _accepted(sockets, partial(Handler, runner.server, headers))
    finally:
        await runner.cleanup()


async def _accepted(sockets: list[socket.socket], handler: Callable[[], asyncio.Protocol]) -> None:
    """Accept connections until a signal arrives."""
    connections, over = Connections(), asyncio.Event()
    with suppress(NotImplementedError):  # on Windows an interrupt ends the loop
        for one in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(one, over.set)
    waiting = [asyncio.ensure_future(connections.accept(one, handler)) for one in sockets]
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
