from __future__ import annotations

import time

import numpy as np
import pytest

from designers.evaluations import Bowl, evaluation
from robomore.designers.offline.designer import OfflineDesigner
from robomore.designers.offline.surrogate import GaussianProcess, expected_improvement
from robomore.tasks.registry import TASKS
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Evaluation, Morphology, Reward, Slot, Status


def slot(index: int, branch: int = 0) -> Slot:
    return Slot("fine", "morphology", (branch, index), improves=True)


def start(designer: OfflineDesigner, count: int) -> list[Morphology]:
    bodies: list[Morphology] = []
    for index in range(count):
        place = Slot("coarse", "morphology", (index,))
        bodies.append(designer.propose_morphology(place, bodies))
    return bodies


@pytest.mark.parametrize("objective", ["efficiency", "fitness"])
@pytest.mark.parametrize(
    "task", ["swimmer", *(pytest.param(t, marks=pytest.mark.exhaustive) for t in ("ant", "hopper"))]
)
def test_ten_steps_beat_the_best_of_history(task: str, objective: str) -> None:
    known = TASKS[task]
    designer = OfflineDesigner(known, 1, objective)
    *bodies, summit = start(designer, 9)
    bowl = Bowl(known, summit.parameters)
    history = [bowl.measure(body) for body in bodies]
    first = best = max(history, key=lambda e: e.score(objective) or 0)
    seconds = time.process_time()
    for index in range(10):
        body = designer.improve_morphology(slot(index), best, history)
        assert known.check(body.parameters) == body.parameters
        assert body.parameters not in {e.design.morphology.parameters for e in history}
        assert "volume" in body.idea
        measured = bowl.measure(body)
        history.append(measured)
        best = max(best, measured, key=lambda e: e.score(objective) or 0)
    assert (time.process_time() - seconds) / 10 < 0.1
    gain = (best.score(objective) or 0) / (first.score(objective) or 1)
    assert gain > (1.1 if objective == "efficiency" else 1.02)


def test_a_step_depends_on_its_arguments_alone() -> None:
    known = TASKS["swimmer"]
    designer = OfflineDesigner(known, 1)
    *bodies, summit = start(designer, 6)
    bowl = Bowl(known, summit.parameters)
    history = [bowl.measure(body) for body in bodies]
    first = designer.improve_morphology(slot(1), history[0], history)
    designer.improve_morphology(slot(2), history[0], history)
    again = OfflineDesigner(known, 1).improve_morphology(slot(1), history[0], history)
    assert again == first
    assert designer.improve_morphology(slot(1, branch=1), history[0], history) != first


def test_failures_and_useless_morphologies_in_the_history_do_no_harm() -> None:
    known = TASKS["swimmer"]
    designer = OfflineDesigner(known, 1)
    bodies = start(designer, 8)
    best = evaluation(known, bodies[0], fitness=4.0)
    outside = Morphology((9.0,) * 6)
    history = [
        best,
        evaluation(known, bodies[1], status=Status.UNSTABLE),
        evaluation(known, outside, status=Status.INVALID_MORPHOLOGY),
        evaluation(known, bodies[2], status=Status.REWARD_FAILED),
        evaluation(known, bodies[3], status=Status.TIMED_OUT),
        evaluation(known, bodies[4], fitness=-2.0),
        evaluation(known, bodies[5], fitness=0.0),
    ]
    body = designer.improve_morphology(slot(0), best, history)
    assert known.check(body.parameters)
    # Even with nothing but the best itself to go by.
    assert known.check(designer.improve_morphology(slot(0), best, ()).parameters)
    # And where the best went nowhere.
    lame = evaluation(known, bodies[6], fitness=-1.0)
    assert known.check(designer.improve_morphology(slot(0), lame, [lame]).parameters)


def test_the_next_step_keeps_away_from_an_unstable_morphology() -> None:
    known = TASKS["swimmer"]
    designer = OfflineDesigner(known, 1)
    bowl = Bowl(known, known.reference)
    space = bowl.space
    centre = np.full(6, 0.5)
    best = bowl.measure(Morphology(tuple(space.values(centre[None])[0].tolist())))
    thinner = centre - np.array([0, 0, 0, 0.1, 0.1, 0.1])
    unstable = evaluation(
        known,
        Morphology(tuple(space.values(thinner[None])[0].tolist())),
        status=Status.UNSTABLE,
    )

    def thickness(history: list[Evaluation]) -> float:
        steps = [designer.improve_morphology(slot(i), best, history) for i in range(8)]
        return float(np.mean([space.units([s.parameters])[0, 3:].mean() for s in steps]))

    assert thickness([best, unstable]) > thickness([best]) + 0.02


def test_a_robot_as_thin_as_can_be_is_tried_in_another_size() -> None:
    known = TASKS["half-cheetah"]
    space = UnitSpace(known)
    thin = np.where(space.radii, [p.low for p in space.task.parameters], known.reference)
    best = evaluation(known, Morphology(tuple(thin.tolist())), fitness=9.0)
    designer = OfflineDesigner(known, 1)
    # Nothing is known of what else changes fitness, and a smaller robot has less volume for sure.
    steps = [designer.improve_morphology(slot(i), best, [best]) for i in range(6)]
    ratios = [(np.array(step.parameters) / thin)[space.lengths] for step in steps]
    alike = [ratio for ratio in ratios if np.ptp(ratio) < 0.01]
    assert alike and all(0.6 < ratio.mean() < 0.95 for ratio in alike)


def test_steps_get_smaller_after_failed_improvements() -> None:
    known = TASKS["swimmer"]
    designer = OfflineDesigner(known, 1)
    space = Bowl(known, known.reference).space
    best = evaluation(known, Morphology(known.reference), fitness=9.0)
    history = [best]

    def size(body: Morphology) -> float:
        gap = space.units([body.parameters]) - space.units([best.design.morphology.parameters])
        return float(np.abs(gap).max())

    sizes = []
    for index in range(4):
        body = designer.improve_morphology(slot(index), best, history)
        sizes.append(size(body))
        history.append(evaluation(known, body, fitness=0.1))
    assert max(sizes[2:]) < sizes[0]


def test_a_morphology_gets_no_credit_for_its_reward() -> None:
    known = TASKS["swimmer"]
    designer = OfflineDesigner(known, 1, "fitness")
    one, other = start(designer, 2)
    good, poor = Reward("good"), Reward("poor")
    # The same worth under each reward; the second body was never tried under the good one.
    history = [
        evaluation(known, one, good, 100.0),
        evaluation(known, one, poor, 1.0),
        evaluation(known, other, poor, 1.0),
    ]
    _, values, counts = designer._morphology_optimizer._training_data(history)
    penalty = designer._morphology_optimizer._prior.penalty(
        np.array([one.parameters, other.parameters])
    )
    first, second = values - penalty
    assert counts.tolist() == [2, 1]
    assert first - second < 0.5 * np.log(100)


def test_the_process_goes_through_its_data_and_doubts_far_from_them() -> None:
    points = np.linspace(0, 1, 9)[:, None]
    values = np.sin(4 * points[:, 0])
    process = GaussianProcess(points, values, np.full(9, 50.0))
    mean, deviation = process.predict(np.array([[0.5], [0.55], [3.0]]))
    assert mean[0] == pytest.approx(np.sin(2.0), abs=0.05)
    assert mean[1] == pytest.approx(np.sin(2.2), abs=0.1)
    assert deviation[2] > 3 * deviation[0]


def test_expected_improvement_is_that_of_a_normal_variable() -> None:
    random = np.random.default_rng(0).normal(0.3, 0.5, 400_000)
    known = float(np.maximum(random - 0.6, 0).mean())
    computed = expected_improvement(np.array([0.3]), np.array([0.5]), 0.6)
    assert computed[0] == pytest.approx(known, rel=0.02)
