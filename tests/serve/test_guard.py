"""Nobody but this machine's browser, or whoever has the token, is answered."""

from __future__ import annotations

import socket
from typing import Any, Self

import pytest

pytest.importorskip("starlette", reason="the extra [serve] is not installed")
pytest.importorskip("uvicorn", reason="the extra [serve] is not installed")

from robomore.serve import running
from robomore.serve.guard import COOKIE, LOOPBACK, Guard
from serve.asking import ask

HOST = {"host": "127.0.0.1:8765"}


async def _shown(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"shown"})


def asked(
    headers: dict[str, str], method: str = "GET", query: str = "", token: str = ""
) -> tuple[int, dict[str, str]]:
    """Return status and headers of the answer to a request."""
    answer = ask(Guard(_shown, LOOPBACK, token), f"/?{query}", headers, method)
    return answer.status, answer.headers


@pytest.mark.parametrize("host", ["127.0.0.1:8765", "localhost:8765", "[::1]:8765", "LocalHost"])
def test_this_machine_is_answered_and_no_page_may_frame_or_guess_it(host: str) -> None:
    status, headers = asked({"host": host})
    assert status == 200
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["cross-origin-resource-policy"] == "same-origin"
    assert "set-cookie" not in headers


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"host": "evil.example:8765"}, 421),  # a name that was made to point here
        ({"host": "127.0.0.1.evil.example"}, 421),
        ({"host": "["}, 421),
        ({}, 421),
        (HOST | {"origin": "http://evil.example"}, 403),
        (HOST | {"origin": "null"}, 403),
        (HOST | {"origin": "http://127.0.0.1:9999"}, 403),
        (HOST | {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"}, 403),
        (HOST | {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}, 200),
        (HOST | {"origin": "http://127.0.0.1:8765"}, 200),
    ],
)
def test_other_hosts_and_origins_are_refused(headers: dict[str, str], status: int) -> None:
    assert asked(headers)[0] == status


@pytest.mark.parametrize("host", ["192.168.1.5:8765", "[fe80::1]:8765", "10.0.0.7"])
def test_whoever_has_the_token_may_ask_by_any_address(host: str) -> None:
    assert asked({"host": host}, query="token=secret", token="secret")[0] == 200
    assert asked({"host": host}, token="secret")[0] == 401
    # Without one, whoever can ask is on this machine, and has its names.
    assert asked({"host": host})[0] == 421
    assert asked({"host": "evil.example"}, query="token=secret", token="secret")[0] == 421


def test_an_address_is_printed_that_others_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    class Datagrams:
        def __init__(self, family: int, kind: int) -> None:
            self.family = family

        def __enter__(self) -> Self:
            return self

        def __exit__(self, *_: object) -> None: ...

        def connect(self, address: tuple[str, int]) -> None:
            if self.family == socket.AF_INET6:
                raise OSError("no route")

        def getsockname(self) -> tuple[str, int]:
            return "192.168.1.5", 4321

    monkeypatch.setattr(socket, "socket", Datagrams)
    assert running._own_address("0.0.0.0") == "192.168.1.5"
    assert running._own_address("::") == socket.gethostname()


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_nothing_can_be_changed(method: str) -> None:
    assert asked(HOST, method)[0] == 405


def test_a_token_is_asked_for_once_and_then_kept_in_a_cookie() -> None:
    assert asked(HOST, token="secret")[0] == 401
    assert asked(HOST, query="token=wrong", token="secret")[0] == 401
    assert asked(HOST | {"cookie": f"{COOKIE}=wrong"}, token="secret")[0] == 401
    status, headers = asked(HOST, query="token=secret", token="secret")
    assert status == 200
    assert "HttpOnly; SameSite=Strict" in headers["set-cookie"]
    cookie = headers["set-cookie"].partition(";")[0]
    assert asked(HOST | {"cookie": cookie}, token="secret")[0] == 200
