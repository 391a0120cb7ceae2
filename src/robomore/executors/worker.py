"""The worker process: reads calls from standard input, one a line, answers on standard output."""

from __future__ import annotations

import os
import queue
import sys
import threading
import traceback

import msgspec

from robomore.executors.executor import load
from robomore.executors.messages import Call, Progressed, Raised, Replied, Reply


def main() -> None:
    """Serve until standard input closes, which it does when the parent ends, however it ends."""
    # Whatever a library prints must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)

    def say(reply: Reply) -> None:
        answers.write(msgspec.json.encode(reply) + b"\n")

    calls: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(calls,), daemon=True).start()
    while True:
        call = msgspec.json.decode(calls.get(), type=Call)
        try:
            reply = load(call.function)(call.payload, lambda units: say(Progressed(units)))
        except Exception:  # noqa: BLE001  # the whole traceback goes to the parent
            say(Raised(traceback.format_exc()))
        else:
            say(Replied(reply))


def _listen(calls: queue.SimpleQueue[bytes]) -> None:
    """Pass calls on; when the parent is gone, end at once and do not finish work nobody awaits."""
    for line in sys.stdin.buffer:
        calls.put(line)
    os._exit(1)


if __name__ == "__main__":
    main()
