"""The worker process: reads calls from standard input and writes replies to standard output.

The messages are one JSON object a line, never pickle.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import traceback

import msgspec

from robomore.errors import UnfitWorker
from robomore.executors.executor import load_function
from robomore.text import to_json


class Call(msgspec.Struct, tag="call", frozen=True):
    """To the worker: run `function` (`module:name`) on `payload`."""

    function: str
    payload: bytes


class Progressed(msgspec.Struct, tag="progress", frozen=True):
    """From the worker: the running job has done so many units."""

    units: int


class Replied(msgspec.Struct, tag="reply", frozen=True):
    """From the worker: the function returned."""

    reply: bytes


class Raised(msgspec.Struct, tag="raised", frozen=True):
    """From the worker: the function raised an exception."""

    traceback: str


class Unfit(msgspec.Struct, tag="unfit", frozen=True):
    """From the worker: this machine cannot do the job (`robomore.errors.UnfitWorker`)."""

    reason: str


Reply = Progressed | Replied | Raised | Unfit


def main() -> None:
    """Run calls until standard input closes, which happens when the parent ends for any reason."""
    # What a library prints must not get between the replies, so it goes to standard error.
    replies = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)

    def send(reply: Reply) -> None:
        replies.write(to_json(reply) + b"\n")

    calls: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(calls,), daemon=True).start()
    while True:
        call = msgspec.json.decode(calls.get(), type=Call)
        try:
            reply = load_function(call.function)(
                call.payload, lambda units: send(Progressed(units))
            )
        except UnfitWorker as error:
            send(Unfit(str(error)))
        except Exception:  # noqa: BLE001  # the whole traceback goes to the parent
            send(Raised(traceback.format_exc()))
        else:
            send(Replied(reply))


def _listen(calls: queue.SimpleQueue[bytes]) -> None:
    """Pass calls on; when the parent is gone, end at once instead of finishing the job."""
    for line in sys.stdin.buffer:
        calls.put(line)
    os._exit(1)


if __name__ == "__main__":
    main()
