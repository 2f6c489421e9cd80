"""The workbench's server on 127.0.0.1: requests need the secret word in the address and come from its own page.

GET of the word's folder is the page, of `events` in it the messages of the open scene as Server-Sent Events, of
`live` those of the run that goes on; of `drawings/NUMBER/STATE` the drawings of a state, of `recording/NAME` what is
played; `folder` lists what there is, `kept/NAME` is a document of the folder. POST takes JSON.
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import re
import secrets
import socket
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgspec
import uvicorn
from heavylift import nodes
from heavylift.kernel.cache import contents, read_cached, sources, write_cached
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.scene import bundled, json_schema
from heavylift.nodes.scene.text.files import scene_file
from heavylift.recordings.render.content import bundled as page_of
from heavylift.recordings.render.server import HEADERS, HOST, PULSE, refusal
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from .open_scene import OpenScene
from .results import compared, keep, kept, played, recordings, result, studies

LARGEST = 1 << 20  # of a request [bytes]
SANDBOX = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"  # of documents: no script of theirs


@cache
def _schema() -> bytes:
    """Return the JSON Schema of scenes, cached under a hash of the code that generates the schema."""
    file = f"{hashlib.sha256(contents(Path(nodes.__file__).parent, '.py', '.yaml') + sources()).hexdigest()}.schema"
    found = read_cached(file)
    if not found:
        found = msgspec.json.encode(json_schema())
        write_cached(file, found)
    return found


class Guard:
    """Middleware that admits only requests addressed to this host, from the workbench's own page, with the secret word
    in their address."""

    def __init__(self, app: ASGIApp, word: str, port: int) -> None:
        self._app, self._word, self._port = app, word, port

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return
        refused = refusal(Headers(scope=scope), self._port)
        _, word, rest = (*str(scope["path"]).split("/", 2), "", "")[:3]

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                more = [(name.lower().encode(), value.encode()) for name, value in HEADERS.items()]
                message["headers"] = [*message["headers"], *more]
            await send(message)

        if refused:
            return await PlainTextResponse(f"{refused}\n", 403)(scope, receive, with_headers)
        if not hmac.compare_digest(word.encode(), self._word.encode()):
            return await PlainTextResponse("no such page; copy the whole address\n", 404)(scope, receive, with_headers)
        await self._app({**scope, "path": f"/{rest}", "raw_path": b""}, receive, with_headers)


class Save(msgspec.Struct):
    """Request to replace this version of the scene by a whole text."""

    text: str
    version: str


class Edit(msgspec.Struct):
    """Request to change one path of the scene: set a value (YAML in one line), remove it (None), or move a list
    item."""

    path: list[str | int]
    value: str | int | None


class Edits(msgspec.Struct):
    """Request for several changes of one version of the scene, of which all or none are made."""

    edits: list[Edit]
    version: str


class Asked(msgspec.Struct):
    """Request of a page to start a run or search, or to give an order to the run in progress."""

    do: str
    text: str = ""


class SceneName(msgspec.Struct):
    """Request that names a scene."""

    name: str


class New(msgspec.Struct):
    """Request for a new scene as a copy of a bundled one, or an empty one."""

    name: str
    like: str


@cache
def _bundled() -> dict[str, str]:
    """Return the first sentence of the description of each bundled scene, by name."""
    heads = {
        name: takewhile(lambda x: x[:1] == "#", path.read_text(encoding="utf-8").splitlines())
        for name, path in bundled().items()
    }
    texts = {name: " ".join(line.lstrip("# ") for line in lines) for name, lines in sorted(heads.items())}
    return {name: re.split(r"(?<=\w\w\.)\s(?=[A-Z])", text)[0] for name, text in texts.items()}


def application(opened: OpenScene, word: str, port: int) -> ASGIApp:
    """Return the web application of the workbench for an open scene, which admits only requests that pass the
    `Guard`."""

    async def page(_: Request) -> Response:
        return HTMLResponse(page_of("workbench", {}, "; img-src data: blob:; connect-src 'self'"))

    async def schema(_: Request) -> Response:
        return Response(await run_in_threadpool(_schema), media_type="application/json")

    async def events(_: Request) -> Response:
        return StreamingResponse(_stream(opened), media_type="text/event-stream")

    async def drawings(request: Request) -> Response:
        number, k = request.path_params["number"], request.path_params["k"]
        found = await run_in_threadpool(opened.drawings, number, k)
        return (
            _json(found)
            if found is not None
            else _refused("the scene has changed since these drawings were requested", 404)
        )

    def posted(name: str, type_: type[Any], change: Callable[[Any], object]) -> Route:
        async def answer(request: Request) -> Response:
            return await _changed(request, type_, change)

        return Route(f"/{name}", answer, methods=["POST"])

    def shown(tell: Callable[..., object]) -> Callable[[Request], Any]:
        async def answer(request: Request) -> Response:
            return await _answered(tell, **request.path_params, **request.query_params)

        return answer

    async def live(request: Request) -> Response:
        if not (address := opened.run.live):
            return _refused("no run with a live page is in progress", 404)
        last = request.headers.get("Last-Event-ID", "")
        return StreamingResponse(_relayed(address, last), media_type="text/event-stream")

    def listed() -> dict[str, Any]:
        folder = opened.folder
        return {"recordings": [*recordings(folder)], "studies": studies(folder), "bundled": _bundled()}

    def document(name: str) -> Response:
        data, kind = kept(opened.folder, name)
        return Response(data, media_type=kind, headers={"Content-Security-Policy": SANDBOX})

    routes = [
        Route("/", page),
        Route("/schema", schema),
        Route("/events", events),
        Route("/drawings/{number:int}/{k:int}", drawings),
        Route("/live", live),
        Route("/folder", shown(listed)),
        Route("/recording/{name}", shown(lambda name, beside="": played(opened.folder, name, beside))),
        Route("/result/{kind}/{name}", shown(lambda kind, name: HTMLResponse(result(opened.folder, kind, name)))),
        Route("/compare/{a}/{b}", shown(lambda a, b: HTMLResponse(compared(opened.folder, a, b)))),
        Route("/kept/{name:path}", shown(document)),
        posted("save", Save, lambda x: opened.save(x.text, x.version)),
        posted("edit", Edits, lambda x: opened.edit([(each.path, each.value) for each in x.edits], x.version)),
        posted("open", SceneName, lambda x: opened.open(x.name)),
        posted("copy", SceneName, lambda x: opened.copy(x.name)),
        posted("new", New, lambda x: opened.new(x.name, x.like)),
        posted("keep", SceneName, lambda x: keep(opened.folder, x.name)),
        posted("run", Asked, lambda x: opened.ask(x.do, x.text)),
    ]
    return Guard(Starlette(routes=routes), word, port)


async def _changed(request: Request, type_: type[Any], change: Callable[[Any], object]) -> Response:
    """Carry out a request that has a JSON body; return its answer, or a response that says why it was refused."""
    if request.headers.get("Content-Type", "").partition(";")[0] != "application/json":
        return _refused("a request of this page must be JSON", 415)
    body = bytearray()
    async for piece in request.stream():
        body += piece
        if len(body) > LARGEST:
            return _refused("the request is too long", 413)
    try:
        asked = msgspec.json.decode(bytes(body), type=type_)
    except msgspec.MsgspecError as error:
        return _refused(f"this request cannot be read: {error}", 400)
    return await _answered(lambda: {"answer": change(asked)})


async def _answered(tell: Callable[..., object], **given: Any) -> Response:
    """Call a function and return its result as a response; an error of heavylift or of the system becomes a response
    409 with a sentence."""
    try:
        found = await run_in_threadpool(tell, **given)
        return found if isinstance(found, Response) else _json(found)
    except HeavyliftError as error:
        return _refused(str(error), 409)
    except OSError as error:
        return _refused(f"{error.filename}: {error.strerror}", 409)


def _json(data: object) -> Response:
    return Response(msgspec.json.encode(data), media_type="application/json")


def _refused(sentence: str, status: int) -> Response:
    return Response(msgspec.json.encode({"error": sentence}), status, media_type="application/json")


async def _stream(opened: OpenScene) -> AsyncIterator[bytes]:
    """Yield the messages of an open scene as Server-Sent Events: first the last one of each kind, then each new one."""
    wake, loop, last = asyncio.Event(), asyncio.get_running_loop(), 0

    def ring() -> None:
        loop.call_soon_threadsafe(wake.set)

    opened.listen(ring)
    try:
        while not opened.closing:
            wake.clear()
            for message in opened.since(last):
                last = message.number
                yield b"event: %s\ndata: %s\n\n" % (message.kind.encode(), message.data)
            try:
                await asyncio.wait_for(wake.wait(), PULSE)
            except TimeoutError:
                yield b": still here\n\n"
    finally:
        opened.forget(ring)


async def _relayed(address: str, last: str) -> AsyncIterator[bytes]:
    """Yield the event stream of the live page of a run, from the message after number `last` on."""
    at = urlsplit(address)
    reader, writer = await asyncio.open_connection(at.hostname, at.port)
    try:
        since = f"Last-Event-ID: {last}\r\n" if last.isdecimal() else ""
        writer.write(f"GET {at.path}events HTTP/1.1\r\nHost: {at.netloc}\r\n{since}\r\n".encode())
        await reader.readuntil(b"\r\n\r\n")
        while piece := await reader.read(1 << 16):
            yield piece
    finally:
        writer.close()


class _WorkbenchServer(uvicorn.Server):
    """A server that closes the event streams of all pages when it is asked to end."""

    def __init__(self, config: uvicorn.Config, opened: OpenScene) -> None:
        super().__init__(config)
        self._opened = opened

    def handle_exit(self, sig: int, frame: Any) -> None:
        """Handle an exit signal: close the event streams of the pages, then let the server exit."""
        self._opened.__exit__()
        super().handle_exit(sig, frame)


@contextmanager
def served(folder: Path, scene: Path | None) -> Iterator[tuple[str, Callable[[], None], uvicorn.Server]]:
    """Yield the address of a server for an open scene, a function that runs the server until exit, and the server."""
    word = secrets.token_urlsafe(24)
    with socket.create_server((HOST, 0)) as listening, OpenScene(folder, scene) as opened:
        port = listening.getsockname()[1]
        settings = uvicorn.Config(
            application(opened, word, port), log_level="critical", access_log=False, lifespan="off", ws="none",
            server_header=False, timeout_graceful_shutdown=1,
        )  # fmt: skip
        server = _WorkbenchServer(settings, opened)
        yield f"http://{HOST}:{port}/{word}/", lambda: server.run(sockets=[listening]), server


def workbench(place: str, ready: Callable[[str], object]) -> None:
    """Serve the workbench for a folder, a scene file, or a bundled scene until a signal ends it; `ready` receives the
    address."""
    folder, scene = Path(place), None
    if not folder.is_dir():
        scene = scene_file(place).resolve()
        if not scene.is_file():
            raise SceneError(f"there is neither a folder nor a scene '{place}'; check the name")
        folder = Path() if scene in bundled().values() else scene.parent
    with served(folder, scene) as (url, run, _):
        ready(url)
        run()
