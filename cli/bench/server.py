"""Serves the page and its WebSocket, to this computer only and only with the token."""

import asyncio
import json
import secrets
import socket
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from importlib.resources import files
from typing import Any, Protocol

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from heatwright.cli.bench.recorded import Unsaid
from heatwright.cli.bench.store import Store, Told

HOST = "127.0.0.1"
NAMES = (HOST, "localhost")
PAGE = {
    "bench.css": ("bench.css", "text/css"),
    "bench.js": ("bench.js", "text/javascript"),
    "panels.js": ("panels.js", "text/javascript"),
    "chart.js": ("chart.js", "text/javascript"),
    "plot.js": ("plot.js", "text/javascript"),
    "uPlot.js": ("uPlot.iife.min.js", "text/javascript"),
    "uPlot.css": ("uPlot.min.css", "text/css"),
}
"""File and media type, by the last part of the address."""
SAFE = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""Headers of every answer: no content from other sites, no display in a frame."""
QUICKLY = 1
"""Level of PNG compression: low, as pictures only go to a browser on this computer."""
LONGEST_ORDER = 4096
"""Maximum number of bytes of a command."""


class Shown(Protocol):
    """The source of a page's data: a board, or a serial line.

    page -- the file of its page; store -- the data for the tabs; when_failed -- called when the
    source has failed.
    """

    page: str
    store: Store
    when_failed: Callable[[], None]

    def order(self, order: Mapping[str, Any], answer: Callable[[str], None]) -> None:
        """Execute a command; answer -- is called with an error message, or ""."""

    def scenario(self) -> str:
        """Return the recorded actions as a scenario file. Raises Unsaid: there are too many."""


class OwnNames:
    """Accepts only requests addressed to this computer, by one of its own names and this port.

    This refuses foreign names that resolve to this computer (DNS rebinding), and scripts of pages
    from other sites.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self._app = app
        self._hosts = {f"{name}:{port}" for name in NAMES}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check `Host` and `Origin`; a WebSocket must have an origin."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        host, origin = headers.get("host"), headers.get("origin")
        is_own = host in self._hosts and origin in {f"http://{host}", None}
        if not is_own or (origin is None and scope["type"] == "websocket"):
            refusal = PlainTextResponse("Refused: only this computer may ask.\n", 403, SAFE)
            if scope["type"] == "websocket":
                await WebSocket(scope, receive, send).close(1008)
            else:
                await refusal(scope, receive, send)
            return
        await self._app(scope, receive, send)


class Pages:
    """The routes of all addresses that begin with the token."""

    def __init__(self, board: Shown, token: str) -> None:
        self._board, self._token = board, token
        self._files = files("heatwright.cli.bench") / "page"
        self.routes = [
            Route("/{token}/", self._guarded(self._page)),
            Route("/{token}/display/{number:int}.png", self._guarded(self._picture)),
            Route("/{token}/scenario.yaml", self._guarded(self._scenario)),
            Route("/{token}/{file}", self._guarded(self._page)),
            WebSocketRoute("/{token}/live", self._live),
        ]

    def _knows(self, asked: Request | WebSocket) -> bool:
        given = str(asked.path_params["token"])
        return secrets.compare_digest(given.encode(), self._token.encode())

    def _guarded(self, answer: Callable[[Request], Response]) -> Callable[[Request], Any]:
        async def guarded(request: Request) -> Response:
            return answer(request) if self._knows(request) else _nothing()

        return guarded

    def _page(self, request: Request) -> Response:
        name = request.path_params.get("file", "")
        found = PAGE.get(name) if name else (self._board.page, "text/html")
        if found is None:
            return _nothing()
        file, kind = found
        return Response((self._files / file).read_bytes(), 200, SAFE, kind)

    def _picture(self, request: Request) -> Response:
        found = self._board.store.pictures.get(request.path_params["number"])
        if found is None:
            return _nothing()
        from heatwright.sim.interfaces.nextion.screen import as_png  # noqa: PLC0415 - slow to import

        return Response(as_png(found, QUICKLY), 200, SAFE, "image/png")

    def _scenario(self, request: Request) -> Response:
        del request
        try:
            text = self._board.scenario()
        except Unsaid as error:
            return PlainTextResponse(f"{error}\n", 409, SAFE)
        told = {"Content-Disposition": 'attachment; filename="scenario.yaml"'}
        return PlainTextResponse(text, 200, SAFE | told)

    async def _live(self, line: WebSocket) -> None:
        if not self._knows(line):
            await line.close(1008)
            return
        await line.accept()
        await _talk(line, self._board)


def _nothing() -> Response:
    return PlainTextResponse("There is nothing here.\n", 404, SAFE)


def app_of(board: Shown, token: str, port: int) -> ASGIApp:
    """Return the server's application for a board; token -- the first part of each address."""
    app = Starlette(routes=Pages(board, token).routes)
    app.router.redirect_slashes = False  # without the token every address answers 404
    return OwnNames(app, port)


async def _talk(line: WebSocket, board: Shown) -> None:
    """Send news to a tab, and receive its commands, until it closes."""
    told, answers = Told(), asyncio.Queue[dict[str, Any]]()
    async with _woken(board) as woken:
        teller = asyncio.create_task(_tell(line, board, told, answers, woken))
        try:
            while True:
                _take(await line.receive_text(), board, told, answers, woken)
        except WebSocketDisconnect:
            pass
        finally:
            teller.cancel()


@asynccontextmanager
async def _woken(board: Shown) -> AsyncIterator[asyncio.Event]:
    """Yield an event that the board's thread sets when there is news."""
    woken, loop = asyncio.Event(), asyncio.get_running_loop()

    def wake() -> None:
        loop.call_soon_threadsafe(woken.set)

    board.store.watchers.add(wake)
    try:
        yield woken
    finally:
        board.store.watchers.discard(wake)


async def _tell(
    line: WebSocket,
    board: Shown,
    told: Told,
    answers: asyncio.Queue[dict[str, Any]],
    woken: asyncio.Event,
) -> None:
    """Send news at once; a slow tab skips updates instead of falling behind."""
    try:
        await _send(line, {"about": board.store.about})
        while True:
            while not answers.empty():
                await _send(line, answers.get_nowait())
            if news := board.store.news(told):
                await _send(line, news)
            await woken.wait()
            woken.clear()
    except (WebSocketDisconnect, RuntimeError):  # the tab was closed meanwhile
        return


async def _send(line: WebSocket, what: Mapping[str, Any]) -> None:
    await line.send_text(json.dumps(what, ensure_ascii=False, allow_nan=False))


def _take(
    text: str,
    board: Shown,
    told: Told,
    answers: asyncio.Queue[dict[str, Any]],
    woken: asyncio.Event,
) -> None:
    """Pass a command to the board; answer anything else with an error."""
    loop = asyncio.get_running_loop()
    order = _order(text)
    number = order.get("number")

    def answer(error: str) -> None:
        found = {"answer": number if isinstance(number, int) else None, "error": error}
        loop.call_soon_threadsafe(answers.put_nowait, found)
        loop.call_soon_threadsafe(woken.set)

    if order.get("do") == "watch":
        told.wants_variables = bool(order.get("variables"))
        answer("")
    else:
        board.order(order, answer)


def _order(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text) if len(text) <= LONGEST_ORDER else None
    except (ValueError, RecursionError):
        found = None
    return found if isinstance(found, dict) else {}


class Server:
    """A server that is bound to a port, and serves once `run` is called.

    address -- the URL of its page; bound_to -- the network address on which it listens. Raises
    OSError: the port is in use.
    """

    def __init__(self, board: Shown, port: int = 0) -> None:
        """Bind the server to a port, or to any free port if it is 0."""
        self._socket = socket.create_server((HOST, port))
        self.bound_to, port = self._socket.getsockname()
        token = secrets.token_urlsafe(16)
        self.address = f"http://{HOST}:{port}/{token}/"
        self._server = uvicorn.Server(
            uvicorn.Config(
                app_of(board, token, port),
                lifespan="off",
                log_level="critical",
                server_header=False,
                timeout_graceful_shutdown=1,
                ws_max_size=LONGEST_ORDER,
                ws_per_message_deflate=False,  # the browser is on this computer
            )
        )
        board.when_failed = self.stop

    def run(self) -> None:
        """Serve until Ctrl-C, or `stop`."""
        self._server.run(sockets=[self._socket])

    def stop(self) -> None:
        """End `run`."""
        self._server.should_exit = True
