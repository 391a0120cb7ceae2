"""The contract check passes our executors and finds each way in which another may break it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Generator, Iterator, Sequence

import pytest

from robomore.executors import Done, Executor, Failed, Outcome
from robomore.executors.executor import Progress, never
from robomore.executors.inline import Inline
from robomore.executors.processes import Processes
from robomore.testing.executors import check_executor


@pytest.mark.parametrize("make", [Inline, lambda: Processes(2)], ids=["inline", "processes"])
def test_our_executors_keep_the_contract(make: Callable[[], Executor]) -> None:
    check_executor(make)


Change = Callable[[Iterator[tuple[int, Outcome]]], Iterator[tuple[int, Outcome]]]


class Broken(Inline):
    """`Inline` with one promise broken."""

    def __init__(
        self, change: Change = lambda outcomes: outcomes, silent: bool = False, deaf: bool = False
    ) -> None:
        super().__init__()
        self.change, self.silent, self.deaf = change, silent, deaf

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        if self.silent:
            progress = lambda index, units: None  # noqa: E731
        if self.deaf:
            should_stop = never
        yield from self.change(super().map(function, payloads, progress, timeout, should_stop))


def twice(outcomes: Iterator[tuple[int, Outcome]]) -> Iterator[tuple[int, Outcome]]:
    for index, outcome in outcomes:
        yield from [(index, outcome)] * (2 if index == 3 else 1)


def swapped(outcomes: Iterator[tuple[int, Outcome]]) -> Iterator[tuple[int, Outcome]]:
    for index, outcome in outcomes:
        yield index ^ 1 if index < 2 else index, outcome


def failures_left_out(outcomes: Iterator[tuple[int, Outcome]]) -> Iterator[tuple[int, Outcome]]:
    return (pair for pair in outcomes if isinstance(pair[1], Done))


def no_reason(outcomes: Iterator[tuple[int, Outcome]]) -> Iterator[tuple[int, Outcome]]:
    for index, outcome in outcomes:
        yield index, Failed("") if isinstance(outcome, Failed) else outcome


@pytest.mark.parametrize(
    ("broken", "complaint"),
    [
        (Broken(twice), "exactly one outcome"),
        (Broken(swapped), "needs Done"),
        (Broken(failures_left_out), "is `Failed`"),
        (Broken(no_reason), "contain the job's exception"),
        (Broken(silent=True), "progress"),
        (Broken(deaf=True), "after the stop"),
    ],
    ids=["twice", "swapped", "failures left out", "no reason", "no progress", "no stop"],
)
def test_a_broken_promise_is_found(broken: Executor, complaint: str) -> None:
    with pytest.raises(AssertionError, match=complaint):
        check_executor(lambda: broken)


class Leaving(Inline):
    """Runs a job in a process that it never ends."""

    process: subprocess.Popen[bytes]

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        if not function.endswith(":wait"):
            yield from super().map(function, payloads, progress, timeout, should_stop)
            return
        code = (
            "import time; from robomore.testing.executors import wait\n"
            f"wait({payloads[0]!r}, print); print(flush=True); time.sleep(60)"
        )
        self.process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
        assert self.process.stdout is not None
        self.process.stdout.readline()
        yield 0, Done(b"")


def test_a_process_that_is_left_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robomore.testing.executors._PROMPTLY", 0.3)
    leaving = Leaving()
    with pytest.raises(AssertionError, match="is left of a worker"):
        check_executor(lambda: leaving)
    leaving.process.kill()
    leaving.process.communicate()
