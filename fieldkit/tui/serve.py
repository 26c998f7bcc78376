"""Serve the app to a browser, on this computer or on a phone in the same network, with textual-serve.

If the server has a token, as that of `fieldkit serve` has, every request needs it; pages of another origin are always
refused. A server without a token also refuses requests that address this computer by a foreign name, because a page may
point its own name to this computer.

Connections to the app's server, with a limit in total and a lower limit per address, so that few can hardly
block others.
"""

import asyncio
import errno
import hmac
import ipaddress
import json
import logging
import os
import signal
import socket
import sys
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from shlex import join
from subprocess import list2cmdline
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSCloseCode, WSMsgType, web
from textual_serve.app_service import AppService
from textual_serve.server import Server

from fieldkit.safe_text import printable

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
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except UnicodeError as error:  # no name of a computer has such letters, or as many
        raise OSError(errno.EINVAL, "no computer has this name") from error
    found = dict.fromkeys((family, where[0]) for family, _, _, _, where in addresses)
    sockets: list[socket.socket] = []
    try:
        for family, name in found:
            sockets.append(socket.create_server((str(name), port), family=family, backlog=MAX_CONNECTIONS))
            sockets[-1].setblocking(False)
        yield sockets
    finally:
        for one in sockets:
            one.close()


LEDGER = "FIELDKIT_LEDGER"
"""The environment variable that names the ledger to the apps: other users of a computer see command lines, and the URL
of a ledger on a server may contain a password."""
PHONE_LETTERS = "10"
"""Font size on a phone: 65 columns fit a width of 390 points. [px]"""
VIEWPORT = '<meta name="viewport" content="width=device-width, initial-scale=1">'
"""Without this tag a phone lays the page out for a desktop and shrinks it until it is unreadable."""
FOCUS = (
    "<script>new MutationObserver((_, seen) => { const keys = document.querySelector('.xterm-helper-textarea');"
    "if (keys) { keys.focus(); seen.disconnect(); } })"
    ".observe(document, { childList: true, subtree: true });</script>"
)
"""Gives the terminal of the page the keys as soon as it is there, without a click."""
NOTHING_ELSE = (
    "default-src 'self' 'unsafe-inline' data: blob:; connect-src 'self' ws: wss:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'; object-src 'none'"
)
"""The browser may not load fonts or anything else from other hosts, because there is no network at the field; no page
may frame the app.
"""
HEADERS = {
    "Content-Security-Policy": NOTHING_ELSE,
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Server": "fieldkit",
}
"""Headers of every HTTP response, including refusals; they keep the link, which contains the token, from being sent to
other sites."""
MAX_LOG_LINE = 500
"""Size limit of a line of the log. [character]"""
MAX_APPS = 8
"""Maximum number of apps that run at the same time, each in its own process. [1]"""
MAX_COLUMNS, MAX_ROWS = 500, 200
"""Largest size of a terminal in a browser. [cells]"""
MAX_MESSAGE = 1 << 20
"""Size limit of a single message from a page, such as pasted text. [byte]"""
HEARTBEAT = 15.0
"""Interval of checks that a page is still connected. [s]"""
PATIENCE = 5.0
"""How long an app may take to exit after its page has closed, before its input is closed. [s]"""
WebHandler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def is_loopback(host: str) -> bool:
    """Whether a host name or address is reachable only from this computer."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def in_a_shell(command: Sequence[str]) -> str:
    """A command for the system's shell, which it replaces if possible, so no process runs in between."""
    return list2cmdline(command) if sys.platform == "win32" else f"exec {join(command)}"


def address(host: str) -> str:
    """The address in a link with which other devices reach this computer, for a host that listens on all interfaces."""
    if host not in ("0.0.0.0", "::"):
        return f"[{host}]" if ":" in host else host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # sends nothing: it only determines the outgoing interface
        return str(probe.getsockname()[0])


def heard(text: str) -> tuple[str, Any] | None:
    """Parse a message from a page: its kind and its data; None for a message that our page does not send."""
    try:
        received = json.loads(text)
    except (ValueError, RecursionError):
        return None
    match received:
        case ["stdin", str(keys)]:
            return "stdin", keys.encode(errors="replace")
        case ["resize", {"width": int(width), "height": int(height)}]:
            return "resize", (min(max(width, 1), MAX_COLUMNS), min(max(height, 1), MAX_ROWS))
        case ["ping", payload]:
            return "ping", payload
        case ["blur" | "focus" as kind, *_]:
            return kind, None
    return None


async def _passed_on(received: tuple[str, Any] | None, page: web.WebSocketResponse, service: AppService) -> bool:
    """Pass a message from a page on to its app; returns whether it was valid."""
    match received:
        case "stdin", keys:
            await service.send_bytes(keys)
        case "resize", (width, height):
            await service.set_terminal_size(width, height)
        case "ping", payload:
            await page.send_json(["pong", payload])
        case "blur", _:
            await service.blur()
        case "focus", _:
            await service.focus()
    return received is not None


async def _end(service: AppService) -> None:
    """End an app: ask it to quit, and close its input if it takes long, after which it exits by itself."""
    stopped = asyncio.ensure_future(service.stop())
    try:
        await asyncio.wait([stopped], timeout=PATIENCE)
    finally:
        service.stdin.close()
    await stopped


async def _sent(send: Callable[[Any], Awaitable[None]], data: bytes | str) -> None:
    """Send an app's output to its page, if that is still open. The rest is read too: the app would otherwise block in a
    write and never end."""
    with suppress(ConnectionResetError):
        await send(data)


def within(text: str, most: int) -> int:
    """A size requested by a page, from 1 to `most`; `most` if it is not a number."""
    return min(max(int(text), 1), most) if text.isascii() and text.isdecimal() and len(text) < 9 else most


def _netloc(origin: str) -> str:
    """Host name and port of an origin, empty for a malformed one."""
    try:
        split = urlsplit(origin)
    except ValueError:
        return ""
    return split.netloc if origin == f"{split.scheme}://{split.netloc}" else ""


class OneLine(logging.Formatter):
    """Formats a log record as one line without control characters; of a traceback only the exception."""

    def format(self, record: logging.LogRecord) -> str:
        """The formatted line."""
        failed = f": {record.exc_info[1]!r}" if record.exc_info and record.exc_info[1] else ""
        return printable(f"{record.getMessage()}{failed}")[:MAX_LOG_LINE]


class GuardedServer(Server):  # type: ignore[misc]  # textual-serve has no types
    """textual-serve with an optional token, which rejects pages of other origins."""

    def __init__(self, host: str, port: int, token: str, ledger: str | None) -> None:
        super().__init__(
            in_a_shell([sys.executable, "-m", "fieldkit.cli.main", "tui"]),
            host,
            port,
            "fieldkit",
            f"http://{address(host)}:{port}",
        )
        self.token = token
        self.ledger = ledger
        self.cookie = f"fieldkit-{port}"
        """The name of the cookie with the token: browsers share cookies between the ports of a computer."""
        self.open: set[web.WebSocketResponse] = set()
        """The sockets of pages connected to an app."""

    def initialize_logging(self) -> None:
        """Log each failure in one line: nothing that a stranger sends reaches the terminal unescaped."""
        logging.basicConfig(level=logging.WARNING, format="%(message)s")
        for handler in logging.getLogger().handlers:
            handler.setFormatter(OneLine())

    def serve(self, debug: bool = False) -> None:
        """Serve until Ctrl-C. Raises OSError if it cannot listen."""
        self.initialize_logging()
        if self.ledger:
            os.environ[LEDGER] = self.ledger
        with suppress(KeyboardInterrupt):
            asyncio.run(self._serve())

    async def _serve(self) -> None:
        await serve(await self._make_app(), self.host, self.port, HEADERS)

    async def on_shutdown(self, app: web.Application) -> None:
        """End the running apps."""
        for one in tuple(self.open):
            await one.close()

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """Run an app for a page, until the page closes or sends an invalid message."""
        page = web.WebSocketResponse(heartbeat=HEARTBEAT, max_msg_size=MAX_MESSAGE)
        self.open.add(page)
        try:
            await page.prepare(request)
            service = AppService(
                self.command,
                write_bytes=partial(_sent, page.send_bytes),
                write_str=partial(_sent, page.send_str),
                close=page.close,
                download_manager=self.download_manager,
            )
            asked = (request.query.get("width", "80"), request.query.get("height", "24"))
            await service.start(within(asked[0], MAX_COLUMNS), within(asked[1], MAX_ROWS))
            try:
                async for message in page:
                    if message.type is WSMsgType.TEXT and not await _passed_on(heard(message.data), page, service):
                        await page.close(code=WSCloseCode.POLICY_VIOLATION)
            finally:
                await _end(service)
        finally:
            self.open.discard(page)
        return page

    @property
    def link(self) -> str:
        """The link to open in a browser."""
        return f"{self.public_url}/" + (f"?token={self.token}" if self.token else "")

    async def _make_app(self) -> web.Application:
        app = await super()._make_app()

        @web.middleware
        async def guarded(request: web.Request, handler: WebHandler) -> web.StreamResponse:
            return await self.guard(request, handler)

        async def headed(_: web.Request, response: web.StreamResponse) -> None:
            response.headers.update(HEADERS)

        app.middlewares.append(guarded)
        app.on_response_prepare.append(headed)
        return app

    def is_ours(self, asked: str) -> bool:
        """Whether a host name and port refer to this server: those of the link, or this computer's loopback names."""
        try:
            split = urlsplit(f"//{asked}")
            here = is_loopback(split.hostname or "") and (split.port or 80) == self.port
        except ValueError:  # not a valid port
            return False
        return here or asked.lower() in self._names()

    def _names(self) -> tuple[str, str]:
        """Host name and port of the link, as browsers write it, and without the usual port."""
        link = urlsplit(self.public_url).netloc.lower()
        return link, link.removesuffix(":80")

    async def on_startup(self, app: web.Application) -> None:
        """Print nothing: the command has already printed the link."""

    async def guard(self, request: web.Request, handler: WebHandler) -> web.StreamResponse:
        """Check access, and set the font size for phones."""
        if isinstance(request.protocol, Handler):
            request.protocol.has_asked = True
        self._refuse_strangers(request)
        if request.path == "/" and request.host.lower() not in self._names():
            raise web.HTTPFound(self.link)  # `localhost`: cookies and sockets belong to one name
        if request.path == "/" and "fontsize" not in request.query and "Mobi" in request.headers.get("User-Agent", ""):
            raise web.HTTPFound(request.rel_url.update_query(fontsize=PHONE_LETTERS))
        if request.path == "/ws" and len(self.open) >= MAX_APPS:
            raise web.HTTPServiceUnavailable(text=f"{MAX_APPS} apps are open already; close one")
        response = await handler(request)
        if isinstance(response, web.Response) and response.content_type == "text/html":
            response.text = (response.text or "").replace("<head>", f"<head>{VIEWPORT}{FOCUS}", 1)
        if self.token and not response.prepared:
            response.set_cookie(self.cookie, self.token, httponly=True, samesite="Strict")
        return response

    def _refuse_strangers(self, request: web.Request) -> None:
        """Raises HTTPForbidden for requests from other pages, and for requests without the token or its cookie.

        Without a token, also for requests that do not address this computer by a loopback name.
        """
        origin = request.headers.get("Origin")
        if origin is not None and not self.is_ours(_netloc(origin)):
            raise web.HTTPForbidden(text="requested by another page")
        shown = request.query.get("token", "") or request.cookies.get(self.cookie, "")
        if self.token and not hmac.compare_digest(shown.encode(errors="replace"), self.token.encode()):
            raise web.HTTPForbidden(
                text="the token is missing or wrong; open the whole link that fieldkit serve printed"
            )
        if not self.token and not self.is_ours(request.host):
            raise web.HTTPForbidden(text=f"opened under another address; open {self.link}")
