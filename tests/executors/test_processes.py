"""Worker processes: what happens to one does not happen to the others."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from robomore.executors import Done, Failed, Outcome, thread_map
from robomore.executors.processes import Processes


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[Processes]:
    here = Path(__file__).parent
    monkeypatch.setenv("PYTHONPATH", f"{here}:{here.parent}")
    with closing(Processes(2)) as executor:
        yield executor


def outcomes(
    executor: Processes, name: str, payloads: list[bytes], timeout: float = 30
) -> list[Outcome]:
    found = dict(executor.map(f"jobs:{name}", payloads, lambda index, units: None, timeout))
    return [found[index] for index in range(len(payloads))]


def test_a_bad_job_costs_only_itself(processes: Processes) -> None:
    payloads = [b"exit", b"fine", b"kill", b"print", b"fine"]
    exited, fine1, killed, printed, fine2 = outcomes(processes, "misbehave", payloads)
    assert isinstance(exited, Failed) and "status 3" in exited.reason
    assert isinstance(killed, Failed) and "SIGKILL" in killed.reason
    assert printed == Done(b"print")
    assert fine1 == fine2 == Done(b"fine")


def test_a_hanging_job_is_ended(processes: Processes) -> None:
    (hung,) = outcomes(processes, "misbehave", [b"hang"], timeout=1.0)
    assert isinstance(hung, Failed) and hung.timed_out and "after 1 s" in hung.reason
    assert outcomes(processes, "misbehave", [b"fine"]) == [Done(b"fine")]


def test_no_key_reaches_a_worker(monkeypatch: pytest.MonkeyPatch, processes: Processes) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "planted")
    monkeypatch.setenv("SOMETHING_SECRET", "planted")
    (seen,) = outcomes(processes, "environment", [b""])
    assert isinstance(seen, Done)
    assert b"PATH" in seen.reply
    assert b"OPENAI_API_KEY" not in seen.reply and b"SOMETHING_SECRET" not in seen.reply


def test_an_error_of_should_stop_is_raised(processes: Processes) -> None:
    def broken() -> bool:
        raise ZeroDivisionError("on purpose")

    with pytest.raises(ZeroDivisionError, match="on purpose"):
        list(processes.map("jobs:misbehave", [b"fine"], lambda index, units: None, 30, broken))


def test_several_threads_share_the_workers(processes: Processes) -> None:
    def batch(count: int) -> list[Outcome]:
        return outcomes(processes, "misbehave", [b"fine"] * count)

    found = thread_map(3)([partial(batch, count) for count in (3, 1, 2)])
    assert [len(one) for one in found] == [3, 1, 2]
    assert all(one == Done(b"fine") for some in found for one in some)


def test_a_batch_that_is_given_up_leaves_the_others_alone(processes: Processes) -> None:
    given_up = processes.map("jobs:misbehave", [b"fine", b"hang"], lambda index, units: None, 60)
    assert next(given_up) == (0, Done(b"fine"))
    given_up.close()
    assert outcomes(processes, "misbehave", [b"fine"] * 3) == [Done(b"fine")] * 3


def test_a_closed_executor_says_so(processes: Processes) -> None:
    processes.close()
    with pytest.raises(RuntimeError, match="is closed"):
        outcomes(processes, "misbehave", [b"fine"])
