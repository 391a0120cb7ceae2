"""Workers answer, and what happens to one does not happen to the others."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from robomore.executors import Done, Failed, Inline, Outcome, Processes


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[Processes]:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    with closing(Processes(2)) as executor:
        yield executor


def outcomes(
    executor: Processes, name: str, payloads: list[bytes], timeout: float = 30
) -> list[Outcome]:
    got = dict(executor.map(f"jobs:{name}", payloads, lambda index, units: None, timeout))
    return [got[index] for index in range(len(payloads))]


def test_every_job_is_answered_once_and_progress_is_told(processes: Processes) -> None:
    told: list[tuple[int, int]] = []
    payloads = [str(i).encode() for i in range(7)]
    got = list(processes.map("jobs:double", payloads, lambda *news: told.append(news), 30))
    assert sorted(got, key=lambda pair: pair[0]) == [
        (i, Done(payload * 2)) for i, payload in enumerate(payloads)
    ]
    assert sorted(told) == sorted((i, units) for i in range(7) for units in (0, 1))


def test_a_bad_job_costs_only_itself(processes: Processes) -> None:
    payloads = [b"raise", b"fine", b"exit", b"fine", b"kill", b"print", b"fine"]
    raised, fine1, exited, fine2, killed, printed, fine3 = outcomes(
        processes, "misbehave", payloads
    )
    assert isinstance(raised, Failed) and "on purpose" in raised.reason
    assert isinstance(exited, Failed) and "status 3" in exited.reason
    assert isinstance(killed, Failed) and "SIGKILL" in killed.reason
    assert printed == Done(b"print")
    assert fine1 == fine2 == fine3 == Done(b"fine")


def test_a_hanging_job_is_given_up(processes: Processes) -> None:
    hung, fine = outcomes(processes, "misbehave", [b"hang", b"fine"], timeout=1.0)
    assert isinstance(hung, Failed) and hung.timed_out and "gave up after 1 s" in hung.reason
    assert fine == Done(b"fine")


def test_no_job_starts_after_the_stop_and_those_under_way_finish(processes: Processes) -> None:
    started: set[int] = set()

    def progress(index: int, units: int) -> None:
        started.add(index)

    stop = threading.Event()
    payloads = [str(i).encode() for i in range(20)]
    got: dict[int, Outcome] = {}
    for index, outcome in processes.map("jobs:double", payloads, progress, 30, stop.is_set):
        got[index] = outcome
        stop.set()
    assert got == {index: Done(payloads[index] * 2) for index in started}
    assert len(got) < len(payloads)
    # The workers are kept: later jobs run as if nothing had been stopped.
    assert outcomes(processes, "double", [b"a"]) == [Done(b"aa")]


def test_an_error_of_the_question_whether_to_stop_is_raised(processes: Processes) -> None:
    def broken() -> bool:
        raise ZeroDivisionError("on purpose")

    with pytest.raises(ZeroDivisionError, match="on purpose"):
        list(processes.map("jobs:double", [b"a"], lambda index, units: None, 30, broken))


def test_no_key_reaches_a_worker(monkeypatch: pytest.MonkeyPatch, processes: Processes) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "planted")
    monkeypatch.setenv("SOMETHING_SECRET", "planted")
    (seen,) = outcomes(processes, "environment", [b""])
    assert isinstance(seen, Done)
    assert b"PATH" in seen.reply
    assert b"OPENAI_API_KEY" not in seen.reply and b"SOMETHING_SECRET" not in seen.reply


def test_inline_answers_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    got = list(Inline().map("jobs:double", [b"a", b"b"], lambda index, units: None, 30))
    assert got == [(0, Done(b"aa")), (1, Done(b"bb"))]


def test_inline_starts_no_job_after_the_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    stop = threading.Event()
    got = []
    for index, _ in Inline().map(
        "jobs:double", [b"a", b"b"], lambda index, units: None, 30, stop.is_set
    ):
        got.append(index)
        stop.set()
    assert got == [0]
