"""The contract of an executor, as one function for the tests of whoever writes an executor."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path

from robomore.executors.executor import Done, Executor, Failed, Outcome

_PROMPTLY = 10.0
"""Seconds that stopping may take, which is far less than the job that is stopped."""

_MOMENT = 0.1
"""Seconds of a job that is not over before a busy machine looks at the one that ended first."""


def check_executor(make: Callable[[], Executor]) -> None:
    """Check that an executor does what `Executor` promises. Takes some seconds.

    The executor must be able to import `robomore` where its jobs run, and must see this machine's
    folder for temporary files.

    Args:
        make: returns a new executor each time it is called. Two workers check the most.

    Raises:
        AssertionError: with the promise that is broken.
    """
    with closing(make()) as executor:
        _check_replies(executor)
        _check_failures(executor)
        _check_stop(executor)
    _check_early_end(make())


def reply(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Job: report one unit and return the payload, or raise or take a moment if it says so."""
    progress(1)
    if payload == b"raise":
        raise ValueError("raised on purpose")
    if payload == b"slow":
        time.sleep(_MOMENT)
    return b"reply to " + payload


def wait(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Job: write the id of this process to the file that `payload` names; a slow one then waits."""
    file = Path(payload.decode())
    file.with_suffix(".part").write_text(str(os.getpid()))
    file.with_suffix(".part").rename(file)
    if file.name == "slow":
        time.sleep(10 * _PROMPTLY)
    return b""


def _check_replies(executor: Executor) -> None:
    reported: dict[int, list[int]] = {}

    def progress(index: int, units: int) -> None:
        reported.setdefault(index, []).append(units)

    payloads = [str(index).encode() for index in range(7)]
    outcomes = list(executor.map(_REPLY, payloads, progress, _TIMEOUT))
    assert sorted(index for index, _ in outcomes) == list(range(7)), (
        f"every payload needs exactly one outcome; 7 payloads got {outcomes}"
    )
    for index, outcome in outcomes:
        expected = Done(b"reply to " + payloads[index])
        assert outcome == expected, f"payload {index} needs {expected}, but got {outcome}"
        assert reported.get(index) == [0, 1], (
            f"the progress of job {index} has to be 0 as it starts and then 1 from the job, "
            f"but was {reported.get(index)}"
        )
    assert not list(executor.map(_REPLY, [], progress, _TIMEOUT)), "no payload, yet an outcome"


def _check_failures(executor: Executor) -> None:
    payloads = [b"raise", b"a", b"raise", b"b", b"c"]
    outcomes = dict(executor.map(_REPLY, payloads, _ignore, _TIMEOUT))
    for index, payload in enumerate(payloads):
        outcome = outcomes.get(index)
        if payload != b"raise":
            assert outcome == Done(b"reply to " + payload), (
                f"a job that raises must not affect the others, but job {index} got {outcome}"
            )
            continue
        assert isinstance(outcome, Failed), f"a job that raises is `Failed`, but was {outcome}"
        assert "raised on purpose" in outcome.reason, (
            f"the reason has to contain the job's exception, but was {outcome.reason!r}"
        )
        assert not outcome.timed_out and not outcome.unstarted, (
            f"a job that raised was started and has not timed out, but was {outcome}"
        )


def _check_stop(executor: Executor) -> None:
    started: set[int] = set()
    outcomes: dict[int, Outcome] = {}
    payloads = [b"slow"] * (20 + 2 * executor.workers)
    for index, outcome in executor.map(
        _REPLY, payloads, lambda index, units: started.add(index), _TIMEOUT, lambda: bool(outcomes)
    ):
        outcomes[index] = outcome
    assert outcomes.keys() == started, (
        "after the stop, exactly the jobs that have started are yielded; "
        f"started: {sorted(started)}, yielded: {sorted(outcomes)}"
    )
    assert len(outcomes) < len(payloads), "jobs were started after the stop"
    assert not list(executor.map(_REPLY, payloads, _ignore, _TIMEOUT, lambda: True)), (
        "jobs were started although `should_stop` returned True from the beginning"
    )


def _check_early_end(executor: Executor) -> None:
    """Close the generator, and then the executor, while a job is running."""
    with tempfile.TemporaryDirectory() as folder:
        quick, slow = Path(folder) / "quick", Path(folder) / "slow"
        outcomes = executor.map(_WAIT, [str(quick).encode(), str(slow).encode()], _ignore, _TIMEOUT)
        assert next(outcomes)[0] == 0, "a job that waits kept a quick one from being yielded"
        if executor.workers > 1:
            _until(slow.exists, "the second of two workers did not start a job")
        began = time.monotonic()
        outcomes.close()
        executor.close()
        executor.close()
        took = time.monotonic() - began
        assert took < _PROMPTLY, f"stopping took {took:.0f} s, it must not wait for jobs"
        for file in (quick, slow):
            if file.exists() and (pid := int(file.read_text())) != os.getpid():
                _until(partial(_ended, pid), f"process {pid} is left of a worker")


def _until(condition: Callable[[], bool], complaint: str) -> None:
    deadline = time.monotonic() + _PROMPTLY
    while not condition():
        assert time.monotonic() < deadline, complaint
        time.sleep(0.02)


def _ended(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def _ignore(index: int, units: int) -> None:
    """Take progress that does not matter."""


_REPLY, _WAIT = f"{__name__}:reply", f"{__name__}:wait"
_TIMEOUT = 20 * _PROMPTLY
