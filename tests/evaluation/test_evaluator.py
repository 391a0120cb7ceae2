"""Batches: known results are looked up, equal trials share one, crashes get a second try."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from robomore.errors import NoWorker, RunFolderError, StorageFailed, TimeLimitReached
from robomore.evaluation.evaluator import Evaluator
from robomore.evaluation.request import Answer, Request
from robomore.events import Event, Finished
from robomore.executors import Done, Failed, Outcome
from robomore.executors.executor import Carry, never
from robomore.settings import Budget
from robomore.store import Ledger, RunFolder
from robomore.tasks import get_task
from robomore.training.policy import MLPPolicy
from robomore.types import (
    Curve,
    Design,
    Evaluation,
    Morphology,
    Place,
    Reward,
    Status,
    TrainerSettings,
    Trial,
)

NUMBERS = {"fitness": 1.0, "volume": 1.0, "efficiency": 1.0}

Script = Callable[[Request], Outcome]


def good(request: Request) -> Outcome:
    """A result that depends on the design and the seed, as a real one does."""
    (x,) = request.job.design.morphology.parameters
    number = x + request.job.seed / 2**31
    evaluation = Evaluation(
        request.key, request.job, Status.OK, fitness=number, volume=1.0, efficiency=number
    )
    return answered(evaluation)


def a_policy(number: float) -> bytes:
    weight = np.full((1, 1), number, np.float32)
    return MLPPolicy((weight,), (np.zeros(1, np.float32),)).to_bytes()


def answered(evaluation: Evaluation, policy: bytes = a_policy(1.0)) -> Outcome:
    return Done(msgspec.json.encode(Answer(evaluation, policy)))


class Scripted:
    """An executor that answers backwards, so that order cannot matter."""

    workers = 2

    def __init__(self, answer: Script = good) -> None:
        self.answer = answer
        self.requests: list[Request] = []

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Callable[[int, int], None],
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        for index in reversed(range(len(payloads))):
            if should_stop():
                return
            request = msgspec.json.decode(payloads[index], type=Request)
            self.requests.append(request)
            progress(index, 0)
            yield index, self.answer(request)

    def close(self) -> None: ...


def trial(x: float, row: int = 0, repeat: int = 0) -> Trial:
    place = Place(stage="coarse", index=(row,), repeat=repeat)
    return Trial(Design(Morphology((x,)), Reward("def _get_rew(): ...")), place)


def evaluator(tmp_path: Path, executor: Scripted, seed: int = 0) -> Evaluator:
    tmp_path.mkdir(exist_ok=True)
    return Evaluator(
        task=get_task("ant"),
        trainer=TrainerSettings(),
        seed=seed,
        versions={"mujoco": "3"},
        ledger=Ledger(tmp_path / "ledger.sqlite"),
        folder=RunFolder(tmp_path),
        executor=executor,
    )


BUDGET = Budget(steps=100, episodes=1)


def test_answers_come_in_the_order_of_the_trials(tmp_path: Path) -> None:
    measured = evaluator(tmp_path, Scripted()).measure(
        [trial(3), trial(1), trial(2)], budget=BUDGET
    )
    assert [e.design.morphology.parameters[0] for e in measured] == [3, 1, 2]


def test_seeds_do_not_depend_on_order_or_batch(tmp_path: Path) -> None:
    together = evaluator(tmp_path / "a", Scripted()).measure([trial(1), trial(2)], budget=BUDGET)
    apart = evaluator(tmp_path / "b", Scripted())
    (second,) = apart.measure([trial(2, row=9)], budget=BUDGET)
    (first,) = apart.measure([trial(1, row=8)], budget=BUDGET)
    assert [first.fitness, second.fitness] == [e.fitness for e in together]
    other = evaluator(tmp_path / "c", Scripted(), seed=1).measure([trial(1)], budget=BUDGET)
    assert other[0].job.seed != first.job.seed


def test_repeats_are_trained_with_other_seeds(tmp_path: Path) -> None:
    measured = evaluator(tmp_path, Scripted()).measure(
        [trial(1, repeat=repeat) for repeat in range(3)], budget=BUDGET
    )
    assert len({e.job.seed for e in measured}) == 3


def test_equal_trials_are_done_once_and_known_ones_never_again(tmp_path: Path) -> None:
    executor = Scripted()
    first = evaluator(tmp_path, executor)
    a, b = first.measure([trial(1, row=0), trial(1, row=1)], budget=BUDGET)
    assert a == b and len(executor.requests) == 1
    first.ledger.close()
    seen: list[Event] = []
    again = evaluator(tmp_path, executor)
    again.observe = seen.append
    assert again.measure([trial(1, row=0)], budget=BUDGET) == [a]
    assert len(executor.requests) == 1
    assert [e.known for e in seen if isinstance(e, Finished)] == [True]
    # Both places remember it.
    assert [place.index for place, _ in again.ledger.placed()] == [(0,), (1,)]


def test_another_budget_is_another_evaluation(tmp_path: Path) -> None:
    executor = Scripted()
    ours = evaluator(tmp_path, executor)
    ours.measure([trial(1)], budget=BUDGET)
    ours.measure([trial(1)], budget=Budget(steps=200, episodes=1))
    assert [request.job.steps for request in executor.requests] == [100, 200]


def test_a_worker_that_dies_once_costs_nothing(tmp_path: Path) -> None:
    lost: list[str] = []

    def dies_once(request: Request) -> Outcome:
        if not lost:
            lost.append(request.key)
            return Failed("the worker process was ended by SIGKILL")
        return good(request)

    executor = Scripted(dies_once)
    measured = evaluator(tmp_path, executor).measure([trial(1), trial(2)], budget=BUDGET)
    assert [e.status for e in measured] == [Status.OK, Status.OK]
    assert [request.key for request in executor.requests].count(lost[0]) == 2


def test_a_design_that_always_kills_its_worker_fails_with_the_reason(tmp_path: Path) -> None:
    def deadly(request: Request) -> Outcome:
        if request.job.design.morphology.parameters == (2.0,):
            return Failed("the worker process was ended by SIGSEGV")
        return good(request)

    ours = evaluator(tmp_path, Scripted(deadly))
    fine, crashed = ours.measure([trial(1), trial(2)], budget=BUDGET)
    assert fine.ok
    assert (crashed.status, crashed.fitness) == (Status.CRASHED, None)
    assert "SIGSEGV" in crashed.diagnosis
    assert ours.ledger.evaluation(crashed.key) == crashed


def test_a_fault_of_ours_is_tried_again_and_told(tmp_path: Path) -> None:
    def faulty(request: Request) -> Outcome:
        return answered(Evaluation(request.key, request.job, Status.FAILED, "OSError"))

    executor = Scripted(faulty)
    (failed,) = evaluator(tmp_path, executor).measure([trial(1)], budget=BUDGET)
    assert failed.status is Status.FAILED and len(executor.requests) == 2


def test_a_fault_of_ours_is_tried_again_by_the_next_process_and_by_this_one_no_more(
    tmp_path: Path,
) -> None:
    def full(request: Request) -> Outcome:
        return answered(Evaluation(request.key, request.job, Status.FAILED, "no space left"))

    executor = Scripted(full)
    first = evaluator(tmp_path, executor)
    (failed,) = first.measure([trial(1)], budget=BUDGET)
    count = len(executor.requests)
    assert first.measure([trial(1)], budget=BUDGET) == [failed]
    assert len(executor.requests) == count
    first.ledger.close()
    healthy = evaluator(tmp_path, Scripted())
    (found,) = healthy.measure([trial(1)], budget=BUDGET)
    assert found.ok and found.key == failed.key
    assert healthy.ledger.evaluation(found.key) == found


def test_no_design_is_blamed_where_nothing_can_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(folder: RunFolder) -> None:
        raise StorageFailed("no space")

    monkeypatch.setattr(RunFolder, "ensure_writable", full)
    ours = evaluator(tmp_path, Scripted(lambda request: Failed("the worker process was ended")))
    with pytest.raises(StorageFailed):
        ours.measure([trial(1)], budget=BUDGET)
    assert ours.ledger.evaluations() == []


def test_no_design_is_blamed_where_no_worker_starts(tmp_path: Path) -> None:
    ours = evaluator(tmp_path, Scripted(lambda request: Failed("no memory", unstarted=True)))
    with pytest.raises(NoWorker, match=r"no memory.*same command"):
        ours.measure([trial(1)], budget=BUDGET)
    assert ours.ledger.evaluations() == []


def test_a_policy_that_comes_out_otherwise_is_not_passed_off(tmp_path: Path) -> None:
    def luckier(request: Request) -> Outcome:
        known = Evaluation(request.key, request.job, Status.OK, episode_fitness=(1.0,), **NUMBERS)
        return answered(known, a_policy(2.0))

    ours = evaluator(tmp_path, Scripted(good))
    (first,) = ours.measure([trial(1)], budget=BUDGET)
    lost = RunFolder(tmp_path).artifacts / first.artifact / "policy.npz"
    lost.unlink()
    ours.executor = Scripted(luckier)
    with pytest.raises(RunFolderError, match="restore it from a copy"):
        ours.restore_policies([first])
    assert ours.ledger.evaluation(first.key) == first
    assert not lost.exists()


def test_policies_come_as_bytes_and_are_kept_with_their_curves(tmp_path: Path) -> None:
    curve = Curve((10, 20), {"alpha": (None, 0.5)})

    def trained(request: Request) -> Outcome:
        known = Evaluation(request.key, request.job, Status.OK, curve=curve, **NUMBERS)
        return answered(known, a_policy(3.0))

    ours = evaluator(tmp_path, Scripted(trained))
    (measured,) = ours.measure([trial(1)], budget=BUDGET)
    assert measured.artifact == measured.key
    kept = RunFolder(tmp_path).artifacts / measured.artifact / "policy.npz"
    assert kept.read_bytes() == a_policy(3.0)
    assert ours.ledger.curve(measured.key) == curve
    known = ours.ledger.evaluation(measured.key)
    assert known is not None and known.curve is None


@pytest.mark.parametrize(
    "reply", [None, "{}", b"{", b"\xff", b"[]", b'{"evaluation": null}', b"[" * 100_000]
)
def test_an_answer_that_cannot_be_read_costs_one_evaluation(tmp_path: Path, reply: Any) -> None:
    (failed,) = evaluator(tmp_path, Scripted(lambda request: Done(reply))).measure(
        [trial(1)], budget=BUDGET
    )
    assert failed.status is Status.FAILED and "cannot be read" in failed.diagnosis


def test_why_it_cannot_be_read_is_one_short_line(tmp_path: Path) -> None:
    reply = msgspec.json.encode({"evaluation": {"key": "\x1b[2J\n" * 10**6}})
    odd = evaluator(tmp_path, Scripted(lambda request: Done(reply)))
    (failed,) = odd.measure([trial(1)], budget=BUDGET)
    assert failed.diagnosis.isprintable() and len(failed.diagnosis) < 1_000


def test_an_answer_for_somebody_else_is_not_believed(tmp_path: Path) -> None:
    def other(request: Request) -> Outcome:
        return answered(Evaluation("other", request.job, Status.OK, fitness=9.0))

    (failed,) = evaluator(tmp_path, Scripted(other)).measure([trial(1)], budget=BUDGET)
    assert failed.status is Status.FAILED and failed.fitness is None


def test_when_the_time_is_up_nothing_new_is_started_and_the_rest_is_kept(tmp_path: Path) -> None:
    executor = Scripted()
    ours = evaluator(tmp_path, executor)
    ours.time_is_up = lambda: len(executor.requests) >= 2
    with pytest.raises(TimeLimitReached, match="1 evaluations"):
        ours.measure([trial(1), trial(2), trial(3)], budget=BUDGET)
    assert len(ours.ledger.evaluations()) == 2
    ours.time_is_up = never
    assert len(ours.measure([trial(1), trial(2), trial(3)], budget=BUDGET)) == 3
    assert len(executor.requests) == 3


def test_an_edited_task_is_another_evaluation(tmp_path: Path) -> None:
    executor = Scripted()
    ours = evaluator(tmp_path, executor)
    (first,) = ours.measure([trial(1)], budget=BUDGET)
    ours.task = replace(ours.task, reward=ours.task.reward + "\n")
    (second,) = ours.measure([trial(1)], budget=BUDGET)
    assert first.key != second.key and len(executor.requests) == 2


def test_a_hanging_design_is_given_up_at_once(tmp_path: Path) -> None:
    executor = Scripted(lambda request: Failed("gave up after 60 s", timed_out=True))
    (hung,) = evaluator(tmp_path, executor).measure([trial(1)], budget=BUDGET)
    assert hung.status is Status.TIMED_OUT and len(executor.requests) == 1


def test_what_was_finished_before_an_interruption_is_kept(tmp_path: Path) -> None:
    def interrupted(request: Request) -> Outcome:
        if request.job.design.morphology.parameters == (1.0,):
            raise KeyboardInterrupt
        return good(request)

    ours = evaluator(tmp_path, Scripted(interrupted))
    with pytest.raises(KeyboardInterrupt):
        ours.measure([trial(1), trial(2)], budget=BUDGET)
    assert [e.design.morphology.parameters for e in ours.ledger.evaluations()] == [(2.0,)]


def test_a_training_goes_on_from_its_checkpoint_until_it_is_dropped(tmp_path: Path) -> None:
    def trains(request: Request) -> Outcome:
        if request.checkpoint:
            Path(request.checkpoint).mkdir(parents=True, exist_ok=True)
        return good(request)

    executor = Scripted(trains)
    ours = evaluator(tmp_path, executor)
    first = ours.measure([trial(1), trial(2), trial(3)], budget=BUDGET, budget_fraction=0.5)
    assert [e.job.steps for e in first] == [BUDGET.steps // 2] * 3
    assert len({request.checkpoint for request in executor.requests}) == 3
    resting = {r.job.design.morphology.parameters: r.checkpoint for r in executor.requests}

    executor.requests.clear()
    ours.measure([trial(1), trial(2)], budget=BUDGET, budget_fraction=0.75)
    assert all(Path(resting[(x,)]).is_dir() for x in (1.0, 2.0))
    assert not Path(resting[(3.0,)]).exists()
    executor.requests.clear()
    (whole,) = ours.measure([trial(1)], budget=BUDGET)
    assert whole.job.steps == BUDGET.steps
    assert [request.checkpoint for request in executor.requests] == [resting[(1.0,)]]
    assert not any(RunFolder(tmp_path).checkpoints.iterdir())


def test_training_in_one_go_keeps_no_checkpoint(tmp_path: Path) -> None:
    executor = Scripted()
    evaluator(tmp_path, executor).measure([trial(1)], budget=BUDGET)
    assert [request.checkpoint for request in executor.requests] == [""]


class Far(Scripted):
    """An executor on other machines, which leaves checkpoints there."""

    def __init__(self) -> None:
        super().__init__()
        self.carried: list[Carry | None] = []

    def map_remote(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Callable[[int, int], None],
        timeout: float,
        should_stop: Callable[[], bool] = never,
        carry: Sequence[Carry | None] = (),
    ) -> Generator[tuple[int, Outcome]]:
        self.carried += carry
        for index, outcome in self.map(function, payloads, progress, timeout, should_stop):
            one = carry[index]
            assert isinstance(outcome, Done)
            left = f"left by {one.name}" if one and one.leave else None
            yield index, Done(outcome.reply, left)


def test_on_other_machines_no_path_is_named_and_checkpoints_are_carried(tmp_path: Path) -> None:
    executor = Far()
    ours = evaluator(tmp_path, executor)
    ours.measure([trial(1), trial(2)], budget=BUDGET, budget_fraction=0.5)
    assert all(not request.scratch for request in executor.requests)
    assert all(request.versions == ours.versions for request in executor.requests)
    names = [one.name for one in executor.carried if one and one.left is None]
    assert len(set(names)) == 2 and {r.checkpoint for r in executor.requests} == set(names)
    assert str(tmp_path) not in msgspec.json.encode(executor.requests).decode()

    executor.carried.clear()
    ours.measure([trial(2)], budget=BUDGET)
    assert executor.carried == [Carry(names[1], f"left by {names[1]}", leave=False)]
    executor.carried.clear()
    ours.measure([trial(1)], budget=BUDGET)
    assert executor.carried == [None], "what was cut, or has ended, is not kept"
