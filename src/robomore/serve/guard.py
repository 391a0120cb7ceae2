"""Who may ask: this machine's browser, or whoever has the token, and no page of another origin."""

from __future__ import annotations

import secrets
from collections.abc import Collection
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
COOKIE = "robomore-token"

_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}


class Guard:
    """ASGI middleware that refuses what is not meant for this server.

    A page of another origin cannot read an answer, but a name that its owner lets point to this
    machine could (DNS rebinding); so the host that was asked for has to be ours. An address is no
    such name. Which addresses lead here, a machine within a container or behind a router does not
    know, so with a token any will do.

    Args:
        app: that is guarded.
        hosts: names by which this server may be asked.
        token: that every request has to bring, in its address or as a cookie; empty for none.
    """

    def __init__(self, app: ASGIApp, hosts: Collection[str], token: str = "") -> None:
        self._app = app
        self._hosts = frozenset(host.lower() for host in hosts)
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        refused = self._refusal(scope["method"], headers, scope["query_string"])
        first = self._asked_with(scope["query_string"])

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                found = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    found.setdefault(name, value)
                if first and not refused:
                    cookie = f"{COOKIE}={self._token}; Path=/; HttpOnly; SameSite=Strict"
                    found.append("set-cookie", cookie)
            await send(message)

        if refused:
            status, said = refused
            await PlainTextResponse(said + "\n", status)(scope, receive, answer)
        else:
            await self._app(scope, receive, answer)

    def _refusal(self, method: str, headers: Headers, query: bytes) -> tuple[int, str] | None:
        """Return status and reason if a request is refused."""
        if method not in ("GET", "HEAD"):
            return 405, "this server only shows; it takes GET and HEAD"
        host = headers.get("host", "")
        name = _name_of(host)
        if name not in self._hosts and not (self._token and _is_address(name)):
            return 421, f"this server is not {host[:100]!r}; name it with --host"
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return 403, "pages of other origins may not ask"
        if (
            headers.get("sec-fetch-site") == "cross-site"
            and headers.get("sec-fetch-mode") != "navigate"
        ):
            return 403, "pages of other origins may not ask"
        if self._token and not (self._asked_with(query) or self._has_cookie(headers)):
            return 401, "open the address that `robomore serve` printed, with its token"
        return None

    def _asked_with(self, query: bytes) -> bool:
        given = parse_qs(query.decode("latin-1")).get("token", [""])[0]
        return bool(self._token) and _same(given, self._token)

    def _has_cookie(self, headers: Headers) -> bool:
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return False
        return COOKIE in cookies and _same(cookies[COOKIE].value, self._token)


def _name_of(host: str) -> str:
    """Return the name in a `Host` header, without a port and brackets."""
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


def _same(given: str, wanted: str) -> bool:
    return secrets.compare_digest(given.encode(), wanted.encode())
