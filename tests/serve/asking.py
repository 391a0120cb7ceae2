"""Asks an application without a server: one request, one whole answer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import anyio

LOCALHOST = {"host": "localhost"}


class Answer(NamedTuple):
    """Status, headers and body."""

    status: int
    headers: dict[str, str]
    body: bytes


def ask(
    app: Any, address: str = "/", headers: Mapping[str, str] = LOCALHOST, method: str = "GET"
) -> Answer:
    """Return the answer to one request."""
    path, _, query = address.partition("?")
    told: list[Any] = []

    async def send(message: Any) -> None:
        told.append(message)

    async def receive() -> Any:
        return {"type": "http.request"}

    scope = {
        "type": "http", "method": method, "path": path, "raw_path": path.encode(),
        "query_string": query.encode(), "root_path": "", "scheme": "http",
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
        "server": ("localhost", 80), "client": ("::1", 1), "http_version": "1.1",
    }  # fmt: skip
    anyio.run(app, scope, receive, send)
    found = {name.decode(): value.decode() for name, value in told[0]["headers"]}
    return Answer(told[0]["status"], found, b"".join(one.get("body", b"") for one in told[1:]))
