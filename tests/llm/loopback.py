"""A server on loopback that speaks the OpenAI protocol, and misbehaves when it is told to."""

from __future__ import annotations

import contextlib
import gzip
import json
import socket
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

KEY = "sk-test-0123456789abcdef"


Step = (
    str
    | bytes
    | tuple[str, str | Callable[[dict[str, Any]], dict[str, int]]]
    | Callable[[dict[str, Any]], str]
)


@dataclass
class Script:
    """What the server does with each request in turn; the last entry is repeated.

    Attributes:
        steps: names of `Handler` methods, (`say`, text), (`counted`, a function of the request's
            body that returns the usage), functions of the body that return the text, which may be
            asked side by side, or bytes that are sent as they are, after which the server hangs up.
        seen: bodies of the requests, in order.
        keys: the authorization of each request.
    """

    steps: list[Step]
    seen: list[dict[str, Any]] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)
    stop: threading.Event = field(default_factory=threading.Event)


def raw(status: str, *headers: str, body: bytes = b"{}") -> bytes:
    """Return an answer as bytes; its length is told unless `headers` say something of it."""
    told = any(one.lower().startswith(("content-length", "transfer")) for one in headers)
    length = [] if told else [f"content-length: {len(body)}"]
    head = [f"HTTP/1.1 {status}", "content-type: application/json", *headers, *length]
    return "\r\n".join(head).encode("latin-1") + b"\r\n\r\n" + body


class Handler(BaseHTTPRequestHandler):
    """Does what its script says."""

    protocol_version = "HTTP/1.1"
    script: Script

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["content-length"])))
        number = len(self.script.seen)
        self.script.seen.append(body)
        self.script.keys.append(self.headers.get("authorization", ""))
        step = self.script.steps[min(number, len(self.script.steps) - 1)]
        if isinstance(step, bytes):
            self.close_connection = True
            with contextlib.suppress(OSError):
                self.wfile.write(step)
        elif isinstance(step, tuple) and callable(step[1]):
            self.say(usage=step[1](body))
        elif isinstance(step, tuple):
            self.say(step[1])
        elif callable(step):
            self.say(step(body))
        else:
            getattr(self, step)()

    def say(self, text: str | None = "ready", **changes: Any) -> None:
        self.send(200, json.dumps(self.answer(text) | changes))

    @staticmethod
    def answer(text: str | None) -> dict[str, Any]:
        return {
            "id": "answer",
            "object": "chat.completion",
            "created": 1,
            "model": "toy",
            "choices": [
                {
                    "index": 0,
                    "message": {"role": "assistant", "content": text},
                    "finish_reason": "stop",
                }
            ],
            "usage": {"prompt_tokens": 100, "completion_tokens": 20, "total_tokens": 120},
        }

    def goodbye(self) -> None:
        self.close_connection = True
        body = json.dumps(self.answer("ready"))
        self.send(200, body, headers={"connection": "close"})

    def busy(self) -> None:
        self.fail(429, "slow down", "rate_limit_exceeded", {"Retry-After": "7"})

    def busy_for_a_second(self) -> None:
        self.fail(429, "slow down", "rate_limit_exceeded", {"Retry-After": "1"})

    def busy_for_an_hour(self) -> None:
        self.fail(429, "slow down", "rate_limit_exceeded", {"Retry-After": "3600"})

    def no_money(self) -> None:
        self.fail(429, "you exceeded your current quota", "insufficient_quota")

    def broken(self) -> None:
        self.send(500, "oops", "text/plain")

    def unavailable(self) -> None:
        self.fail(503, "loading the model", "unavailable")

    def wrong_key(self) -> None:
        key = self.headers["authorization"].removeprefix("Bearer ")
        self.fail(401, f"incorrect key provided: {key}", "invalid_api_key")

    def wrong_model(self) -> None:
        self.fail(404, "the model 'toy' does not exist", "model_not_found")

    def wrong_path(self) -> None:
        self.send(404, "<!doctype html><html><body>nothing here</body></html>", "text/html")

    def no_schema(self) -> None:
        asked = self.script.seen[-1]
        if "response_format" in asked:
            self.fail(400, "response_format is not supported", "invalid_request_error")
        else:
            self.say('{"length": 1}')

    def refused(self) -> None:
        key = self.headers["authorization"]
        self.fail(400, f"temperature is not supported; you sent {key}", "invalid_request_error")

    def too_long(self) -> None:
        self.fail(400, "maximum context length is 10 tokens", "context_length_exceeded")

    def alternatives(self) -> None:
        answer = self.answer("ready")
        self.send(200, json.dumps(answer | {"choices": answer["choices"] * 50_000}))

    def page(self) -> None:
        self.send(200, "<!doctype html><html><body>please log in</body></html>", "text/html")

    def half(self) -> None:
        self.send(200, '{"id": "answer", "object": "chat.compl')

    def no_choices(self) -> None:
        self.say(choices=[])

    def null_choices(self) -> None:
        self.say(choices=None)

    def nested(self) -> None:
        self.send(200, '{"choices": ' + "[" * 100_000 + "]" * 100_000 + "}")

    def choices_as_text(self) -> None:
        self.say(choices="x")

    def choices_as_numbers(self) -> None:
        self.say(choices=[1, 2])

    def message_as_list(self) -> None:
        self.say(choices=[{"index": 0, "message": ["x"], "finish_reason": "stop"}])

    def content_as_number(self) -> None:
        self.end_as("stop", content=5)

    def error_as_answer(self) -> None:
        self.send(200, '{"object": "error", "message": "out of memory", "code": 500}')

    def broken_page(self) -> None:
        self.send(500, "<!doctype html><html><body>oops</body></html>", "text/html")

    def not_an_object(self) -> None:
        self.send(200, "[1, 2, 3]")

    def endless(self) -> None:
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.end_headers()
        self.close_connection = True
        with contextlib.suppress(OSError):
            for _ in range(200):
                self.wfile.write(b" " * 2**20)

    def drip_body(self) -> None:
        """Send one byte after the other, each in time for a limit that is for one byte."""
        self.drip(b"HTTP/1.1 200 OK\r\ncontent-type: application/json\r\n\r\n", b" ")

    def drip_head(self) -> None:
        self.drip(b"HTTP/1.1 200 OK\r\nx: ", b"a")

    def drip_continue(self) -> None:
        self.drip(b"", b"HTTP/1.1 100 Continue\r\n\r\n")

    def drip(self, first: bytes, then: bytes) -> None:
        self.close_connection = True
        with contextlib.suppress(OSError):
            self.wfile.write(first)
            while not self.script.stop.wait(0.05):
                self.wfile.write(then)

    def gzip(self) -> None:
        self.compressed(200, gzip.compress(json.dumps(self.answer("ready")).encode()), "gzip")

    def deflate(self) -> None:
        self.compressed(200, zlib.compress(json.dumps(self.answer("ready")).encode()), "deflate")

    def gzip_bomb(self) -> None:
        self.compressed(200, gzip.compress(b" " * 2**24), "gzip")

    def deflate_bomb(self) -> None:
        self.compressed(200, zlib.compress(b" " * 2**24), "deflate")

    def bomb_of_an_error(self) -> None:
        self.compressed(400, gzip.compress(b" " * 2**24), "gzip")

    def unknown_encoding(self) -> None:
        self.compressed(200, b"x" * 100, "br")

    def compressed(self, status: int, data: bytes, encoding: str) -> None:
        self.send(status, data, headers={"content-encoding": encoding})

    def end_as(self, reason: str, text: str | None = None, **message: Any) -> None:
        said = {"role": "assistant", "content": text} | message
        self.say(choices=[{"index": 0, "message": said, "finish_reason": reason}])

    def filtered(self) -> None:
        self.end_as("content_filter")

    def filtered_midway(self) -> None:
        self.end_as("content_filter", '{"len')

    def refusing(self) -> None:
        self.end_as("stop", refusal="I cannot help with that.")

    def thinking_only(self) -> None:
        self.end_as("stop", "", reasoning_content='{"length": 2}')

    def thinking_cut_off(self) -> None:
        self.end_as("length", "", reasoning_content="Let me think about that. " * 9)

    def thinking_and_answer(self) -> None:
        self.end_as("stop", "ready", reasoning_content='{"length": 1}')

    def tool_call(self) -> None:
        call = {"name": "answer", "arguments": '{"length": 2}'}
        self.end_as("tool_calls", tool_calls=[{"id": "1", "type": "function", "function": call}])

    def silent(self) -> None:
        self.say(None)

    def uncounted(self) -> None:
        self.say("ready", usage=None)

    def surrogate(self) -> None:
        self.say("a\ud800b")

    def cut_off(self) -> None:
        message = {"role": "assistant", "content": '{"length": '}
        self.say(choices=[{"index": 0, "message": message, "finish_reason": "length"}])

    def drop(self) -> None:
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", "1000")
        self.end_headers()
        self.wfile.write(b'{"id": "answer", "obj')
        self.wfile.flush()
        self.connection.shutdown(socket.SHUT_RDWR)
        self.close_connection = True

    def stall(self) -> None:
        self.script.stop.wait(60)
        self.close_connection = True

    def fail(
        self, status: int, message: str, code: str, headers: dict[str, str] | None = None
    ) -> None:
        body = {"error": {"message": message, "type": code, "code": code}}
        self.send(status, json.dumps(body), headers=headers)

    def send(
        self,
        status: int,
        body: str | bytes,
        kind: str = "application/json",
        headers: dict[str, str] | None = None,
    ) -> None:
        data = body.encode() if isinstance(body, str) else body
        self.send_response(status)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        self.send_header("content-type", kind)
        self.send_header("content-length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)


@contextmanager
def serve(*steps: Step) -> Iterator[tuple[str, Script]]:
    """Serve `steps` in turn; gives the base URL and what was seen."""
    script = Script(list(steps))
    handler = type("Scripted", (Handler,), {"script": script})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/v1", script
    finally:
        script.stop.set()
        server.shutdown()
        server.server_close()
        thread.join()
