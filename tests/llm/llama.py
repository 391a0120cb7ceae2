"""A real llama.cpp server on loopback, with a model of random weights: real protocol, nonsense.

The server itself is llama.cpp's. Before it stands a small relay that gives each request a grammar,
so that a model that knows nothing still writes designs of the right form: llama.cpp keeps the
structure of a JSON schema but not the bounds of its numbers, and for program text there is no
schema at all. At its first try in a conversation the model may also write an excuse.
"""

from __future__ import annotations

import json
import threading
import urllib.request
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.error import HTTPError

import numpy as np

WIDTH = 16
CONTEXT = 65_536
_TEMPLATE = "{% for m in messages %}{{ m['role'] }}: {{ m['content'] }}\n{% endfor %}assistant: "


def write_model(path: Path, seed: int = 0) -> None:
    """Write a llama of one layer with random weights, whose tokens are bytes."""
    import gguf

    random = np.random.default_rng(seed)
    writer = gguf.GGUFWriter(str(path), "llama")
    writer.add_context_length(CONTEXT)
    writer.add_embedding_length(WIDTH)
    writer.add_block_count(1)
    writer.add_feed_forward_length(WIDTH)
    writer.add_head_count(1)
    writer.add_head_count_kv(1)
    writer.add_layer_norm_rms_eps(1e-5)
    writer.add_rope_dimension_count(WIDTH)
    kinds = gguf.TokenType
    writer.add_tokenizer_model("llama")
    writer.add_token_list(["<unk>", "<s>", "</s>", *(f"<0x{i:02X}>" for i in range(256))])
    writer.add_token_scores([0.0] * 259)
    writer.add_token_types([kinds.UNKNOWN, kinds.CONTROL, kinds.CONTROL, *[kinds.BYTE] * 256])
    writer.add_bos_token_id(1)
    writer.add_eos_token_id(2)
    writer.add_unk_token_id(0)
    writer.add_add_space_prefix(False)
    writer.add_chat_template(_TEMPLATE)
    for name in ("output_norm", "blk.0.attn_norm", "blk.0.ffn_norm"):
        writer.add_tensor(f"{name}.weight", np.ones(WIDTH, np.float32))
    square = ("attn_q", "attn_k", "attn_v", "attn_output", "ffn_gate", "ffn_up", "ffn_down")
    shapes = {f"blk.0.{name}": (WIDTH, WIDTH) for name in square}
    for name, shape in (shapes | {"token_embd": (259, WIDTH), "output": (259, WIDTH)}).items():
        weights = 0.1 * random.standard_normal(shape)
        writer.add_tensor(f"{name}.weight", weights.astype(np.float32))
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def morphology_grammar(schema: dict[str, Any]) -> str:
    """Return a grammar (GBNF) of designs within the schema's bounds."""
    numbers = schema["properties"]["parameters"]["properties"]
    rules = []
    fields = []
    for index, (name, bounds) in enumerate(numbers.items()):
        low, high = bounds["minimum"], bounds["maximum"]
        spread = np.geomspace(low, high, 40) if low > 0 else np.linspace(low, high, 40)
        choices = sorted({f"{value:.3g}" for value in spread[1:-1]})
        rules.append(f"n{index} ::= " + " | ".join(f'"{choice}"' for choice in choices))
        fields.append(f'"\\"{name}\\": " n{index}')
    inside = ' ", " '.join(fields)
    rules.append(
        f'design ::= "{{\\"parameters\\": {{" {inside} "}}, \\"description\\": \\"" word " " word '
        '"\\"}"'
    )
    return "\n".join(rules)


REWARD_GRAMMAR = r"""
design ::= "```python\n" code "```"
number ::= [0-9] "." [0-9] [0-9]
code ::= "def _get_rew(self, x_velocity, action):\n" idea speed effort total
idea ::= "    \"\"\"Reward " word " " word ".\"\"\"\n"
speed ::= "    speed = " number " * float(x_velocity)\n"
effort ::= "    effort = " number " * float(np.sum(np.square(action)))\n"
total ::= "    reward = speed - effort\n    return reward, " terms "\n"
terms ::= "{\"speed\": speed, \"effort\": -effort}"
"""


def _rooted(grammar: str, body: dict[str, Any]) -> str:
    first = not any(message["role"] == "assistant" for message in body["messages"])
    root = 'root ::= design | "Sorry, " word ", but no"' if first else "root ::= design"
    return "\n".join([root, "word ::= [a-z]{3,9}", grammar])


class _Relay(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_url: str

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["content-length"])))
        form = body.pop("response_format", None)
        if form is not None and form["json_schema"]["name"] == "morphology":
            body["grammar"] = _rooted(morphology_grammar(form["json_schema"]["schema"]), body)
        elif any("_get_rew" in message["content"] for message in body["messages"]):
            body["grammar"] = _rooted(REWARD_GRAMMAR, body)
        # The same conversation gets the same answer, whoever else is asking.
        body["seed"] = zlib.crc32(json.dumps(body["messages"]).encode())
        request = urllib.request.Request(
            self.server_url + self.path,
            json.dumps(body).encode(),
            {"content-type": "application/json"},
        )
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                status, data = answer.status, answer.read()
        except HTTPError as error:
            status, data = error.code, error.read()
        self.send_response(status)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)


@contextmanager
def serve_llama(folder: Path) -> Iterator[str]:
    """Serve a random model from `folder`; gives the base URL."""
    import xllamacpp

    path = folder / "random.gguf"
    write_model(path)
    params = xllamacpp.CommonParams()
    params.model.path = str(path)
    params.n_ctx = CONTEXT
    params.n_parallel = 1
    params.hostnames = ["127.0.0.1"]
    params.port = 0
    params.warmup = False
    params.verbosity = 0
    params.cpuparams.n_threads = 1
    server = xllamacpp.Server(params)
    handler = type("Relay", (_Relay,), {"server_url": server.listening_address.rstrip("/")})
    relay = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    relay.daemon_threads = True
    thread = threading.Thread(target=relay.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield f"http://127.0.0.1:{relay.server_port}/v1"
    finally:
        relay.shutdown()
        relay.server_close()
        thread.join()
        del server
