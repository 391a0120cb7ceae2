"""The pages of the live server, and the stream that says when they changed."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Collection
from pathlib import Path

from sse_starlette.sse import EventSourceResponse
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route

from robomore.report.page import render
from robomore.report.replays import kept_policies, recorded
from robomore.report.scripts import bundle, policy, style
from robomore.serve.folder import Look, ServedFolder, Watched, why_not_shown
from robomore.serve.guard import LOOPBACK, Guard
from robomore.serve.live import overview, run_page

_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; style-src-attr 'unsafe-inline'; "
    "img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
_LOOK_SECONDS = 0.5
_PING_SECONDS = 15
_MOST_EPISODES = 40


def application(root: Path, hosts: Collection[str] = LOOPBACK, token: str = "") -> Starlette:
    """Return the application that shows the runs below a folder.

    Args:
        root: of the runs; it may be a run itself.
        hosts: names by which the server may be asked.
        token: that every request has to bring; empty for none.
    """
    pages = _Pages(ServedFolder(root))
    return Starlette(
        routes=[
            Route("/", pages.overview),
            Route("/events", pages.events),
            Route("/run", pages.run),
            Route("/run/events", pages.run_events),
            Route("/run/report", pages.report),
            Route("/run/replay", pages.replay),
            Route("/bundle.js", lambda _: Response(bundle(), media_type="text/javascript")),
            Route("/style.css", lambda _: Response(style(), media_type="text/css")),
        ],
        middleware=[Middleware(Guard, hosts=hosts, token=token)],
    )


class _Pages:
    """What is answered to each address."""

    def __init__(self, folder: ServedFolder) -> None:
        self._folder = folder
        self._episodes: dict[tuple[str, str], bytes | None] = {}
        self._recording = threading.Lock()

    async def overview(self, request: Request) -> Response:
        def page() -> str:
            return overview(self._folder.root, [one.read() for one in self._folder.runs()])

        return _page(await run_in_threadpool(page))

    async def run(self, request: Request) -> Response:
        whole = request.query_params.get("part") != "progress"
        return await self._of_run(request, lambda one: _page(run_page(one.read(), whole)))

    async def report(self, request: Request) -> Response:
        def page(one: Watched) -> Response:
            found = one.read()
            if found.run is None:
                return PlainTextResponse(found.error + "\n", 404)
            rule = f"{policy()}; frame-ancestors 'none'"
            return HTMLResponse(render(found.run), headers={"content-security-policy": rule})

        return await self._of_run(request, page)

    async def replay(self, request: Request) -> Response:
        key = request.query_params.get("key", "")

        def episode(one: Watched) -> Response:
            packed = self._episode(one, key)
            if packed is None:
                return PlainTextResponse("it has no policy that could be shown\n", 404)
            return Response(packed, media_type="application/octet-stream")

        return await self._of_run(request, episode)

    async def events(self, request: Request) -> Response:
        return _stream(self._folder.look)

    async def run_events(self, request: Request) -> Response:
        def look() -> Look:
            # A folder that vanished looks like no other, so that the page hears of it.
            found = self._folder.run(request.query_params.get("name", ""))
            return found.look() if found else Look((), "gone", due=False, progress=())

        return _stream(look)

    async def _of_run(self, request: Request, answer: Callable[[Watched], Response]) -> Response:
        def found() -> Response:
            name = request.query_params.get("name", "")
            one = self._folder.run(name)
            if one is None:
                return PlainTextResponse("there is no such run (any more)\n", 404)
            try:
                return answer(one)
            except Exception as error:  # noqa: BLE001  # the folder may come from anybody
                return PlainTextResponse(why_not_shown(one.path, error) + "\n", 500)

        return await run_in_threadpool(found)

    def _episode(self, one: Watched, key: str) -> bytes | None:
        """Return a packed episode; each is recorded once, and one at a time."""
        with self._recording:
            name = one.name, key
            run = one.read().run
            if name not in self._episodes:
                if run is None or key not in set(kept_policies(run)):
                    return None
                if len(self._episodes) >= _MOST_EPISODES:
                    self._episodes.pop(next(iter(self._episodes)))
                self._episodes[name] = recorded(run, key, key)
            return self._episodes[name]


def _page(text: str) -> Response:
    return HTMLResponse(text, headers={"content-security-policy": _POLICY})


def _stream(look: Callable[[], Look]) -> Response:
    """Return a stream of `changed` (all is new) and `progress` (only how far it is)."""

    async def events() -> AsyncIterator[dict[str, str]]:
        async for name in changes(look):
            yield {"event": name, "data": ""}

    return EventSourceResponse(events(), ping=_PING_SECONDS)


async def changes(look: Callable[[], Look], seconds: float = _LOOK_SECONDS) -> AsyncIterator[str]:
    """Yield `changed` when a page is out of date and asking brings what is new, else `progress`.

    A change within the rest after a reading is told when the rest is over: whoever asks earlier is
    given what was read before it. It is told again for as long as nobody asks.

    Args:
        look: what is new.
        seconds: between two looks.
    """
    # Whoever comes back after the server was away looks again.
    yield "changed"
    before = await run_in_threadpool(look)
    told = {before.read, before.now} if before.due else {before.read}
    while True:
        await asyncio.sleep(seconds)
        now = await run_in_threadpool(look)
        if now.due or now.read not in told:
            told = {now.read, now.now} if now.due else {now.read}
            yield "changed"
        elif now.progress != before.progress:
            yield "progress"
        before = now
