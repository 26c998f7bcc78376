"""The app in a browser: on this computer freely, elsewhere with a token, and never for another page."""

import asyncio
import json
from pathlib import Path

import pytest

pytest.importorskip("textual_serve", reason="needs the extra `serve`")

from aiohttp import ClientSession, WSMsgType, WSServerHandshakeError, web

from fieldkit.tui.serve import GuardedServer, address, is_loopback
from tests.pressing import season


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


async def test_nobody_gets_in_without_the_token(unused_tcp_port: int) -> None:
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
            assert (await flyer.get(base, params={"token": "a token"})).status == 200
            cookies = {cookie.key: cookie.value for cookie in flyer.cookie_jar}
            assert cookies == {"fieldkit": "a token"} or not cookies  # a jar keeps none for bare addresses
            evil = {"Origin": "http://elsewhere.example"}
            assert (await flyer.get(base, params={"token": "a token"}, headers=evil)).status == 403
    finally:
        await runner.cleanup()


@pytest.mark.slow  # its child's pipes are left open, which is charged to whatever test runs when they are swept up
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
async def test_the_app_is_shown_through_the_socket(unused_tcp_port: int, tmp_path: Path) -> None:
    season(tmp_path / "ledger.db")
    server = GuardedServer("127.0.0.1", unused_tcp_port, "", str(tmp_path / "ledger.db"))
    runner = await running(server)
    shown = b""
    try:
        async with ClientSession() as browser:
            assert "fieldkit" in await (await browser.get(f"http://127.0.0.1:{unused_tcp_port}/")).text()
            url = f"http://127.0.0.1:{unused_tcp_port}/ws?width=80&height=24"
            async with browser.ws_connect(url, origin=server.public_url) as socket, asyncio.timeout(60):
                async for message in socket:
                    shown += message.data if message.type is WSMsgType.BINARY else b""
                    if b"Astra" in shown and b"Flights" in shown:
                        await socket.send_str(json.dumps(["stdin", "q"]))
                        break
    finally:
        await runner.cleanup()
    assert b"Astra" in shown
