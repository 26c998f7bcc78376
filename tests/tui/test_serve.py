"""The app in a browser: on this computer without a token, elsewhere with one, and never for another website."""

import asyncio
import base64
import io
import json
import logging
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

pytest.importorskip("textual_serve", reason="needs the extra `serve`")

from aiohttp import (
    ClientConnectionError,
    ClientSession,
    ClientWebSocketResponse,
    WSCloseCode,
    WSMsgType,
    WSServerHandshakeError,
    web,
)

from fieldkit.tui import serve
from fieldkit.tui.serve import FOCUS, VIEWPORT, GuardedServer, address, in_a_shell, is_loopback
from tests.pressing import ROOT, season

PATIENCE = 300.0
"""Time limit for a server, a browser and the app on a busy machine. [s]"""
BINARY = 2
"""Opcode of a binary frame: the app's output."""
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


async def running(server: GuardedServer) -> web.AppRunner:
    """A server that listens until its runner is cleaned up."""
    runner = web.AppRunner(await server._make_app())
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", server.port).start()
    return runner


def test_only_this_computer_is_loopback() -> None:
    assert [is_loopback(host) for host in ("127.0.0.1", "::1", "localhost")] == [True] * 3
    assert [is_loopback(host) for host in ("0.0.0.0", "192.168.1.2", "::", "field.local")] == [False] * 4
    assert address("192.168.1.2") == "192.168.1.2"
    assert address("::1") == "[::1]"


def test_the_app_is_started_with_the_quoting_of_the_systems_shell(monkeypatch: pytest.MonkeyPatch) -> None:
    command = ["C:\\Program Files\\python.exe", "-m", "fieldkit.cli.main"]
    monkeypatch.setattr(sys, "platform", "win32")
    assert in_a_shell(command) == '"C:\\Program Files\\python.exe" -m fieldkit.cli.main'
    monkeypatch.setattr(sys, "platform", "linux")
    assert in_a_shell(["/opt/my python", "-m"]) == "exec '/opt/my python' -m"


def test_two_servers_on_one_computer_have_separate_cookies() -> None:
    """Browsers send the cookies of a computer to all of its ports, and replace those of the same name."""
    one, other = (GuardedServer("127.0.0.1", port, f"token {port}", None) for port in (8001, 8002))
    assert one.cookie != other.cookie


def test_the_password_of_a_ledger_is_not_on_the_apps_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other users of a shared computer see command lines, but not the environment."""
    monkeypatch.setenv(serve.LEDGER, "another")
    monkeypatch.setattr(asyncio, "run", lambda work: work.close())
    monkeypatch.setattr(GuardedServer, "initialize_logging", lambda server: None)
    server = GuardedServer("127.0.0.1", 8000, "a token", "postgresql://me:secret@host/db")
    server.serve()
    assert "secret" not in server.command
    assert os.environ[serve.LEDGER] == server.ledger


async def test_access_requires_the_token(unused_tcp_port: int) -> None:
    server = GuardedServer("127.0.0.1", unused_tcp_port, "a token", None)
    runner = await running(server)
    base = f"http://127.0.0.1:{unused_tcp_port}/"
    try:
        async with ClientSession() as stranger:
            for path in ("", "?token=guessed", "ws", "static/"):
                assert (await stranger.get(base + path)).status == 403
            with pytest.raises(WSServerHandshakeError):
                await stranger.ws_connect(base + "ws")
        async with ClientSession() as flyer:
            answer = await flyer.get(base, params={"token": "a token"})
            assert answer.status == 200
            assert {name: one.value for name, one in answer.cookies.items()} == {
                f"fieldkit-{unused_tcp_port}": "a token"
            }
            evil = {"Origin": "http://elsewhere.example"}
            assert (await flyer.get(base, params={"token": "a token"}, headers=evil)).status == 403
    finally:
        await runner.cleanup()


async def test_a_foreign_host_name_that_resolves_to_this_computer_is_refused(unused_tcp_port: int) -> None:
    runner = await running(GuardedServer("127.0.0.1", unused_tcp_port, "", None))
    base, here = f"http://127.0.0.1:{unused_tcp_port}/", f"127.0.0.1:{unused_tcp_port}"
    try:
        async with ClientSession() as anyone:
            for host in (
                "evil.example",
                f"evil.example:{unused_tcp_port}",
                f"127.0.0.1.evil.example:{unused_tcp_port}",
            ):
                for path in ("", "ws", "static/"):
                    assert (await anyone.get(base + path, headers={"Host": host})).status == 403
                with pytest.raises(WSServerHandshakeError):
                    await anyone.ws_connect(base + "ws", headers={"Host": host}, origin=f"http://{host}")
            assert (await anyone.get(base, headers={"Host": here, "Origin": f"http://{here}"})).status == 200
            for host in (f"localhost:{unused_tcp_port}", f"[::1]:{unused_tcp_port}"):
                headers = {"Host": host, "Origin": f"http://{host}"}
                answer = await anyone.get(base, headers=headers, allow_redirects=False)
                assert (answer.status, answer.headers["Location"]) == (302, base)
            for origin in (f"http://localhost:{unused_tcp_port + 1}", "http://localhost:none", "null"):
                assert (await anyone.get(base, headers={"Origin": origin})).status == 403
    finally:
        await runner.cleanup()


async def test_localhost_opens_the_app_under_the_name_of_the_link(unused_tcp_port: int) -> None:
    """Its page, its socket and its cookie belong to one origin."""
    runner = await running(GuardedServer("127.0.0.1", unused_tcp_port, "a token", None))
    try:
        async with ClientSession() as flyer:
            answer = await flyer.get(
                f"http://127.0.0.1:{unused_tcp_port}/?token=a+token",
                headers={"Host": f"localhost:{unused_tcp_port}"},
                allow_redirects=False,
            )
            assert answer.status == 302
            followed = await flyer.get(answer.headers["Location"])
            assert followed.status == 200
            assert f"ws://127.0.0.1:{unused_tcp_port}/ws" in await followed.text()
    finally:
        await runner.cleanup()


async def test_invalid_requests_are_refused_in_one_line(unused_tcp_port: int, caplog: pytest.LogCaptureFixture) -> None:
    runner = await running(GuardedServer("127.0.0.1", unused_tcp_port, "a token", None))
    base = f"http://127.0.0.1:{unused_tcp_port}/"
    bad_headers = [{"Origin": "http://[::1"}, {"Cookie": 'fieldkit="\\377\udcff'}, {"Referer": "http://x/\x1b]0;owned"}]
    try:
        async with ClientSession() as stranger:
            for headers in bad_headers:
                try:
                    answer = await stranger.get(base, headers=headers)
                except (ValueError, UnicodeError):
                    continue  # a client that sends no such thing
                assert answer.status in (400, 403)
                assert "Traceback" not in await answer.text()
    finally:
        await runner.cleanup()
    assert not [record for record in caplog.records if record.exc_info]


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("?token=a+token", 200),
        ("", 403),
        ("nothing?token=a+token", 404),
        ("static/none?token=a+token", 404),
        ("download/none?token=a+token", 404),
        ("ws?token=a+token", 503),
    ],
)
async def test_every_response_forbids_framing_and_caching(
    unused_tcp_port: int, path: str, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "MAX_APPS", 0)
    runner = await running(GuardedServer("127.0.0.1", unused_tcp_port, "a token", None))
    try:
        async with ClientSession() as flyer:
            answer = await flyer.get(f"http://127.0.0.1:{unused_tcp_port}/{path}")
    finally:
        await runner.cleanup()
    assert answer.status == status
    assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
    expected = {"X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer", "Cache-Control": "no-store"}
    assert expected.items() <= dict(answer.headers).items()
    assert "aiohttp" not in answer.headers["Server"]


@pytest.mark.parametrize(
    ("text", "payload"),
    [
        ('["stdin", "q"]', ("stdin", b"q")),
        ('["stdin", "\\ud800"]', ("stdin", b"?")),
        ('["resize", {"width": 80, "height": 24}]', ("resize", (80, 24))),
        ('["resize", {"width": 100000, "height": -5}]', ("resize", (500, 1))),
        ('["ping", 3]', ("ping", 3)),
        ('["blur"]', ("blur", None)),
        *((text, None) for text in ("", "{}", "[]", '["stdin", 5]', '["stdin"]', '["resize", "x"]', '["more"]')),
        ('["resize", {"width": 1e9, "height": 1}]', None),
        ("[" * 100_000, None),
    ],
)
def test_messages_from_a_page_are_bounded_or_ignored(text: str, payload: object) -> None:
    assert serve.heard(text) == payload


async def test_a_client_without_the_token_cannot_use_up_all_connections(
    unused_tcp_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "MAX_CONNECTIONS", 6)
    app = await GuardedServer("127.0.0.1", unused_tcp_port, "a token", None)._make_app()
    serving = asyncio.ensure_future(serve.serve(app, "127.0.0.1", unused_tcp_port, serve.HEADERS))
    try:
        async with asyncio.timeout(PATIENCE), ClientSession() as http:
            await listening_(http, f"http://127.0.0.1:{unused_tcp_port}/")
        held = [await asyncio.open_connection("127.0.0.1", unused_tcp_port) for _ in range(3)]
        reading, writing = await asyncio.open_connection("127.0.0.1", unused_tcp_port)
        assert await reading.read() == b""
        writing.close()
        for _, one in held:
            one.close()
            await one.wait_closed()
        async with asyncio.timeout(PATIENCE), ClientSession() as http:
            assert "token" in await listening_(http, f"http://127.0.0.1:{unused_tcp_port}/")
    finally:
        serving.cancel()
        with suppress(asyncio.CancelledError):
            await serving


class Transport(asyncio.BaseTransport):
    """A connection that may be closing."""

    closing = False

    def is_closing(self) -> bool:
        return self.closing


@asynccontextmanager
async def listening_server(port: int) -> AsyncIterator[GuardedServer]:
    """A server as `fieldkit serve` runs it, until it is canceled."""
    server = GuardedServer("127.0.0.1", port, "a token", None)
    running_ = asyncio.ensure_future(server._serve())
    try:
        async with ClientSession() as http:
            await listening_(http, f"http://127.0.0.1:{port}/?token=a+token")
        yield server
    finally:
        running_.cancel()
        with suppress(asyncio.CancelledError):
            await running_


@pytest.mark.parametrize(
    "sent",
    [
        b"GET /?token=a+token HTTP/1.1\r\nHost: x\r\nDate: \x1b[2J\r\n\r\n",
        b"GET *?token=a+token HTTP/1.1\r\nHost: x\r\n\r\n",
        b"GET /%s HTTP/1.1\r\nHost: x\r\n\r\n" % (b"a" * 9000),
        b"\x16\x03\x01\r\n\r\n",
    ],
)
async def test_a_malformed_request_is_refused_with_the_headers_and_not_echoed(
    unused_tcp_port: int, sent: bytes
) -> None:
    async with listening_server(unused_tcp_port):
        reader, writer = await asyncio.open_connection("127.0.0.1", unused_tcp_port)
        writer.write(sent)
        answer = await asyncio.wait_for(reader.read(), PATIENCE)
        writer.close()
    head, _, body = answer.partition(b"\r\n\r\n")
    assert head.split()[1] == b"400"
    assert b"frame-ancestors 'none'" in head
    assert b"Server: fieldkit" in head
    assert body == b"malformed request"


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\nHost: "])
async def test_a_connection_without_a_request_ends(
    unused_tcp_port: int, monkeypatch: pytest.MonkeyPatch, sent: bytes
) -> None:
    monkeypatch.setattr(serve, "IDLE_PERIOD", 0.2)
    async with listening_server(unused_tcp_port):
        reader, writer = await asyncio.open_connection("127.0.0.1", unused_tcp_port)
        writer.write(sent)
        with suppress(ConnectionResetError):
            assert await asyncio.wait_for(reader.read(), PATIENCE) == b""
        writer.close()


async def test_a_connection_that_cannot_be_accepted_does_not_stop_the_server(
    unused_tcp_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some systems report a connection that was closed before it was accepted."""
    loop = asyncio.get_running_loop()
    accept, failures = loop.sock_accept, [ConnectionAbortedError(), OSError(24, "too many open files")]

    async def failing(listener: Any) -> Any:
        if failures:
            raise failures.pop()
        return await accept(listener)

    monkeypatch.setattr(loop, "sock_accept", failing)
    async with listening_server(unused_tcp_port), ClientSession() as http:
        assert (await http.get(f"http://127.0.0.1:{unused_tcp_port}/?token=a+token")).status == 200
    assert not failures


def test_a_closed_connection_makes_room_for_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serve, "MAX_CONNECTIONS", 2)
    connections, here = serve.Connections(), [Transport(), Transport()]
    for one in here:
        connections.came(one, "10.0.0.1")
    assert not connections.has_room("10.0.0.2")
    here[0].closing = True
    assert connections.has_room("10.0.0.2")


def test_two_addresses_leave_room_for_others() -> None:
    connections = serve.Connections()
    for host in ("10.0.0.1", "10.0.0.2", "10.0.0.3"):
        while connections.has_room(host):
            connections.came(Transport(), host)
    assert connections.has_room("10.0.0.4")


async def test_the_number_of_simultaneous_apps_is_limited(
    unused_tcp_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "MAX_APPS", 0)
    runner = await running(GuardedServer("127.0.0.1", unused_tcp_port, "a token", None))
    try:
        async with ClientSession() as flyer:
            with pytest.raises(WSServerHandshakeError, match="503"):
                await flyer.ws_connect(f"http://127.0.0.1:{unused_tcp_port}/ws?token=a+token")
    finally:
        await runner.cleanup()


@pytest.mark.parametrize(
    ("asked", "most", "given"), [("80", 500, 80), ("99999", 500, 500), ("-4", 500, 500), ("0", 9, 1)]
)
def test_a_terminal_has_a_plausible_size(asked: str, most: int, given: int) -> None:
    assert serve.within(asked, most) == given


def test_a_log_message_is_one_harmless_line() -> None:
    record = logging.LogRecord("x", logging.ERROR, "", 0, "a \x1b[2J\nb", (), (ValueError, ValueError("c\nd"), None))
    payload = serve.OneLine().format(record)
    assert "\x1b" not in payload
    assert "\n" not in payload


@pytest.fixture
def served(unused_tcp_port: int, tmp_path: Path) -> Iterator[str]:
    """The link by which `fieldkit serve` shows a season."""
    season(tmp_path / "ledger.db")
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", str(tmp_path / "ledger.db")]
    home = {"PYTHONPATH": str(ROOT), "FIELDKIT_HOME": str(tmp_path)}
    with child([*command, "serve", "--port", str(unused_tcp_port)], home, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        yield next(line.decode().split()[1] for line in process.stderr if line.startswith(b"open http"))


@contextmanager
def child(
    command: list[str], environment: dict[str, str], stderr: int = subprocess.DEVNULL
) -> Iterator["subprocess.Popen[bytes]"]:
    """A program that is ended at the end."""
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": stderr}
    with subprocess.Popen(command, env=os.environ | environment, **quiet) as process:  # type: ignore[call-overload]
        try:
            yield process
        finally:
            process.terminate()


async def listening_(http: ClientSession, url: str) -> str:
    """A server's output, once there is some."""
    while True:
        try:
            async with http.get(url) as answer:
                return await answer.text()
        except ClientConnectionError:
            await asyncio.sleep(0.1)


class Browser:
    """A page in Chromium, driven by its DevTools protocol. `came` contains what its sockets received."""

    def __init__(self, socket: ClientWebSocketResponse) -> None:
        self.socket, self.came, self._calls = socket, b"", 0

    async def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of a command; messages that arrive in the meantime are kept."""
        self._calls += 1
        await self.socket.send_json({"id": self._calls, "method": method, "params": parameters})
        while (message := await self._heard()).get("id") != self._calls:
            pass
        assert "error" not in message, message
        return dict(message["result"])

    async def _heard(self) -> dict[str, Any]:
        message: dict[str, Any] = await self.socket.receive_json()
        frame = message.get("params", {}).get("response", {})
        if message.get("method") == "Network.webSocketFrameReceived" and frame["opcode"] == BINARY:
            self.came += base64.b64decode(frame["payloadData"])
        return message

    async def until(self, *texts: bytes) -> None:
        """Wait until all of these texts have arrived."""
        while not all(text in self.came for text in texts):
            await self._heard()

    async def phone(self) -> None:
        """Have the width of a phone, and identify as one; the ratio of pixels is the browser's own, because terminals
        measure the screen, which an emulated ratio leaves as it is."""
        agent = "Mozilla/5.0 (Linux; Android 15) AppleWebKit/537.36 Chrome/140.0.0.0 Mobile Safari/537.36"
        await self.call("Network.enable")
        await self.call("Network.setUserAgentOverride", userAgent=agent)
        await self.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=0, mobile=True)

    async def press(self, key: str) -> None:
        """Press a key that types a character."""
        await self.call("Input.dispatchKeyEvent", type="keyDown", key=key, text=key)
        await self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    async def picture(self) -> bytes:
        """The page as PNG."""
        return base64.b64decode((await self.call("Page.captureScreenshot"))["data"])


@asynccontextmanager
async def browsing(http: ClientSession, folder: Path, pixel_ratio: int = 1) -> AsyncIterator[Browser]:
    """A headless Chromium with one empty page, on a screen with this many pixels for one of a page. [1]"""
    port = folder / "DevToolsActivePort"
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0", f"--user-data-dir={folder}"]
    flags.append(f"--force-device-scale-factor={pixel_ratio}")
    with child([str(CHROMIUM), *flags, "about:blank"], {}):
        while not port.exists() or not port.read_text().strip():
            await asyncio.sleep(0.1)
        pages = json.loads(await listening_(http, f"http://127.0.0.1:{port.read_text().splitlines()[0]}/json/list"))
        url = next(page["webSocketDebuggerUrl"] for page in pages if page["type"] == "page")
        async with http.ws_connect(url, max_msg_size=0) as socket:
            yield Browser(socket)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
async def test_a_phones_browser_shows_the_app_and_its_keys_turn_pages(served: str, tmp_path: Path) -> None:
    async with asyncio.timeout(PATIENCE), ClientSession() as http:
        page = await listening_(http, served)
        assert VIEWPORT in page
        assert FOCUS in page
        async with browsing(http, tmp_path / "chromium", pixel_ratio=2) as browser:
            await browser.phone()
            await browser.call("Page.navigate", url=served)
            await browser.until(b"Flights", b"Astra", b"No open forecast")
            first = await browser.picture()
            assert b"Save this flight" not in browser.came
            await browser.press("2")  # without a tap before
            await browser.until(b"Save this flight")
            await asyncio.sleep(0.5)  # until it is painted
            second = await browser.picture()
            where = await browser.call("Runtime.evaluate", expression="location.href + ' ' + innerWidth")
            drawn = await browser.call("Runtime.evaluate", expression="document.querySelector('canvas').width")
    assert where["result"]["value"] == f"{served}&fontsize=10 390"
    assert drawn["result"]["value"] == 2 * 390, "nothing is clipped at two pixels for one"
    for name, picture in (("first", first), ("second", second)):
        (tmp_path / f"{name}.png").write_bytes(picture)
        colours = Image.open(io.BytesIO(picture)).convert("RGB").getcolors(1 << 24)
        assert len(colours) > 20, "the page is blank"
    assert first != second


@pytest.mark.thorough
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
async def test_a_browser_enforces_the_headers(served: str, tmp_path: Path) -> None:
    refused = """new Promise(done => {
        document.addEventListener("securitypolicyviolation", event => done(event.effectiveDirective));
        fetch("http://127.0.0.1:9/").catch(() => 0);
    })"""
    framed = """new Promise(done => {
        const frame = document.createElement("iframe");
        frame.onload = () => done(frame.contentDocument === null ? "refused" : "framed");
        frame.src = location.href;
        document.body.append(frame);
    })"""
    async with asyncio.timeout(PATIENCE), ClientSession() as http:
        await listening_(http, served)
        async with browsing(http, tmp_path / "chromium") as browser:
            await browser.call("Network.enable")
            await browser.call("Page.navigate", url=served)
            await browser.until(b"Flights", b"Astra")
            elsewhere = await browser.call("Runtime.evaluate", expression=refused, awaitPromise=True)
            cookie = await browser.call("Runtime.evaluate", expression="document.cookie")
            inside = await browser.call("Runtime.evaluate", expression=framed, awaitPromise=True)
    assert elsewhere["result"]["value"] == "connect-src"
    assert cookie["result"]["value"] == ""
    assert inside["result"]["value"] == "refused"


async def test_a_client_that_sends_invalid_messages_is_disconnected(served: str) -> None:
    base, query = served.split("/?")
    async with asyncio.timeout(PATIENCE), ClientSession() as http:
        await listening_(http, served)
        async with http.ws_connect(f"{base}/ws?width=80&height=24&{query}", origin=base) as socket:
            await socket.send_str('["stdin", 5]')
            async for _ in socket:
                pass
            assert socket.close_code == WSCloseCode.POLICY_VIOLATION


async def test_the_app_is_sent_through_the_socket(served: str) -> None:
    shown = b""
    async with asyncio.timeout(PATIENCE), ClientSession() as http:
        assert "fieldkit" in await listening_(http, served)
        base, query = served.split("/?")
        async with http.ws_connect(f"{base}/ws?width=80&height=24&{query}", origin=base) as socket:
            async for message in socket:
                shown += message.data if message.type is WSMsgType.BINARY else b""
                if b"Astra" in shown and b"Flights" in shown:
                    await socket.send_str(json.dumps(["stdin", "q"]))
                    break
    assert b"Astra" in shown


def children(process: int) -> set[int]:
    """The child processes of a process, and theirs."""
    found: set[int] = set()
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            number, parent = int(status.parent.name), int(status.read_text().rpartition(")")[2].split()[1])
        except OSError:  # it has ended
            continue
        if parent == process:
            found |= {number} | children(number)
    return found


def alive(processes: Iterable[int]) -> set[int]:
    """The processes that have not ended; a zombie has ended."""
    found = set()
    for one in processes:
        with suppress(OSError):
            if Path(f"/proc/{one}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z":
                found.add(one)
    return found


@pytest.mark.sampled
@pytest.mark.skipif(sys.platform != "linux", reason="processes are read from /proc")
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM, None])
async def test_apps_whose_output_is_not_read_end_with_their_server_or_page(
    end: signal.Signals | None, unused_tcp_port: int, tmp_path: Path
) -> None:
    """An app's output fills every buffer, so that a write blocks when its server or its page ends."""
    season(tmp_path / "ledger.db")
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", str(tmp_path / "ledger.db")]
    home = {"PYTHONPATH": str(ROOT), "FIELDKIT_HOME": str(tmp_path)}
    with child([*command, "serve", "--port", str(unused_tcp_port)], home, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        link = next(line.decode().split()[1] for line in process.stderr if line.startswith(b"open http"))
        base, query = link.split("/?")
        async with asyncio.timeout(PATIENCE), ClientSession() as http:
            await listening_(http, link)
            async with http.ws_connect(f"{base}/ws?width=500&height=200&{query}", origin=base) as socket:
                async for message in socket:
                    if message.type is WSMsgType.BINARY and b"No flights yet today" in message.data:
                        break
                for number in range(100):
                    await socket.send_str(json.dumps(["stdin", "123456"[number % 6]]))
                    await asyncio.sleep(0.02)
                apps = children(process.pid)
                assert apps
                if end is not None:
                    process.send_signal(end)
                elif http.connector is not None:
                    await http.connector.close()
                while alive(apps):
                    await asyncio.sleep(0.1)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are read from /proc")
async def test_apps_end_when_their_server_is_killed(unused_tcp_port: int, tmp_path: Path) -> None:
    season(tmp_path / "ledger.db")
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", str(tmp_path / "ledger.db")]
    home = {"PYTHONPATH": str(ROOT), "FIELDKIT_HOME": str(tmp_path)}
    with child([*command, "serve", "--port", str(unused_tcp_port)], home, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        link = next(line.decode().split()[1] for line in process.stderr if line.startswith(b"open http"))
        base, query = link.split("/?")
        async with asyncio.timeout(PATIENCE), ClientSession() as http:
            await listening_(http, link)
            async with http.ws_connect(f"{base}/ws?width=80&height=24&{query}", origin=base) as socket:
                shown = b""
                async for message in socket:
                    shown += message.data if message.type is WSMsgType.BINARY else b""
                    if b"No flights yet today" in shown:
                        break
                apps = children(process.pid)
                assert apps
                process.kill()
            while any(Path(f"/proc/{app}").exists() for app in apps):
                await asyncio.sleep(0.1)


@pytest.mark.parametrize(
    ("host", "port", "asked", "is_ours"),
    [
        ("Field-Laptop", 8000, "field-laptop:8000", True),
        ("Field-Laptop", 80, "field-laptop", True),
        ("192.168.1.5", 80, "192.168.1.5", True),
        ("192.168.1.5", 8000, "192.168.1.5", False),
        ("192.168.1.5", 8080, "192.168.1.5:80", False),
        ("Field-Laptop", 80, "other-laptop", False),
        ("192.168.1.5", 8000, "localhost:8000", True),
    ],
)
def test_a_host_is_known_as_a_browser_writes_it(host: str, port: int, asked: str, is_ours: bool) -> None:
    assert GuardedServer(host, port, "a token", None).is_ours(asked) == is_ours
