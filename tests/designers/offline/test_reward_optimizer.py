from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import pytest

from designers.evaluations import EACH_TASK, evaluation
from robomore.designers.offline.designer import OfflineDesigner
from robomore.designers.offline.reward_composition import RewardComposition, parse_composition
from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.envs.reward_text import reward_function
from robomore.tasks.registry import TASKS
from robomore.types import Evaluation, Morphology, Reward, Slot, Status, TermStatistics

HOPPER = TASKS["hopper"]
ROBOT = RewardSampler(HOPPER, 0).robot
REFERENCE = Morphology(HOPPER.reference)
PLAIN = {"forward_speed": 2.0, "alive": 0.8, "effort": 0.05}
TRIES = 40


def slot(index: int) -> Slot:
    return Slot("fine", "reward", (0, index), improves=True)


def written(weights: Mapping[str, float]) -> Reward:
    return Reward(RewardComposition(weights).source(ROBOT))


def measured(
    weights: Mapping[str, float] = PLAIN,
    terms: Mapping[str, float] | None = None,
    fitness: float = 5.0,
    **behaviour: float,
) -> Evaluation:
    """Return an evaluation of the reference morphology; `terms` are means of steady terms."""
    statistics = {
        name: TermStatistics(mean, mean - 0.1, mean + 0.1) for name, mean in (terms or {}).items()
    }
    return evaluation(
        HOPPER, REFERENCE, written(weights), fitness, behaviour=behaviour, terms=statistics
    )


def improved(best: Evaluation, history: list[Evaluation] | None = None) -> list[RewardComposition]:
    """What many branches would try next."""
    designer = OfflineDesigner(HOPPER, 2)
    made = []
    for index in range(TRIES):
        reward = designer.improve_reward(slot(index), best, history or [best])
        composition = parse_composition(reward.source, ROBOT)
        assert composition is not None and composition.lead is not None
        made.append(composition)
    return made


def share(compositions: list[RewardComposition], name: str, above: float = 0.0) -> float:
    return sum(one.weights.get(name, 0.0) > above for one in compositions) / len(compositions)


def test_a_dominant_term_gets_less_weight() -> None:
    balanced = {"forward_speed": 2.0, "alive": 0.3, "effort": -0.1}
    dominated = {"forward_speed": 0.2, "alive": 0.8, "effort": -0.1}
    calm = improved(measured(terms=balanced, forward_speed_m_s=1.0))
    corrected = improved(measured(terms=dominated, forward_speed_m_s=1.0))
    lowered = [r.weights.get("alive", 0.0) < 0.8 for r in corrected]
    usual = [r.weights.get("alive", 0.0) < 0.8 for r in calm]
    assert sum(lowered) > 2 * sum(usual)


def test_a_robot_that_falls_gets_a_more_stable_reward() -> None:
    falls = improved(measured(fell_share=1.0, forward_speed_m_s=1.0))
    stands = improved(measured(fell_share=0.0, forward_speed_m_s=1.0))

    def steadier(compositions: list[RewardComposition]) -> float:
        names = ("upright", "lean", "riding_height")
        return share(compositions, "alive", 0.8) + sum(share(compositions, name) for name in names)

    assert steadier(falls) > steadier(stands) + 0.3


def test_a_robot_that_stands_still_gets_a_reward_for_motion() -> None:
    still = improved(measured(fell_share=0.0, forward_speed_m_s=0.05))
    runs = improved(measured(fell_share=0.0, forward_speed_m_s=3.0))
    changes = (("activity",), ("early_progress",), ("forward_speed", 3.0))
    moved = sum(share(still, *change) for change in changes)
    before = sum(share(runs, *change) for change in changes)
    assert moved > before + 0.3


def test_jerky_actions_get_a_cost() -> None:
    jerky = improved(measured(mean_jerk=1.5, forward_speed_m_s=1.0))
    smooth = improved(measured(mean_jerk=0.2, forward_speed_m_s=1.0))
    assert share(jerky, "jerkiness") > share(smooth, "jerkiness") + 0.1


def test_terms_are_copied_from_rewards_with_good_scores() -> None:
    best = measured(forward_speed_m_s=1.0)
    other = Morphology((*HOPPER.reference[:-1], 0.05))
    springy = written({**PLAIN, "springy_knee": 0.3})
    rival = evaluation(HOPPER, other, springy, 50.0)
    weak = evaluation(HOPPER, other, written(PLAIN), 1.0)
    assert share(improved(best, [best, rival, weak]), "springy_knee") > (
        share(improved(best), "springy_knee") + 0.1
    )


def test_every_change_is_new_and_runs() -> None:
    designer = OfflineDesigner(HOPPER, 2)
    best = measured(forward_speed_m_s=0.1, fell_share=1.0, mean_jerk=1.2)
    history = [best]
    for index in range(30):
        reward = designer.improve_reward(slot(index), best, history)
        assert reward.source not in {e.design.reward.source for e in history}
        assert reward.idea
        reward_function(reward.source)
        history.append(evaluation(HOPPER, REFERENCE, reward, 1.0))
    assert max(Counter(e.design.reward.source for e in history).values()) == 1


def test_any_reward_can_be_improved() -> None:
    designer = OfflineDesigner(HOPPER, 2)
    best = evaluation(HOPPER, REFERENCE, Reward(HOPPER.reward), 5.0)
    failed = evaluation(HOPPER, REFERENCE, Reward("def"), status=Status.INVALID_REWARD)
    reward = designer.improve_reward(slot(0), best, [best, failed])
    composition = parse_composition(reward.source, ROBOT)
    assert composition is not None
    assert composition.lead is not None


def test_a_change_depends_on_its_arguments_alone() -> None:
    best = measured(forward_speed_m_s=1.0)
    first = OfflineDesigner(HOPPER, 2)
    made = [first.improve_reward(slot(index), best, [best]) for index in range(6)]
    second = OfflineDesigner(HOPPER, 2)
    assert [second.improve_reward(slot(i), best, [best]) for i in reversed(range(6))] == made[::-1]
    assert len({reward.source for reward in made}) > 3


@pytest.mark.parametrize("task", EACH_TASK)
def test_rewards_of_all_tasks_can_be_improved(task: str) -> None:
    known = TASKS[task]
    designer = OfflineDesigner(known, 0)
    start = designer.propose_reward(Slot("coarse", "reward", (0,)), ())
    best = evaluation(known, Morphology(known.reference), start, 2.0)
    assert designer.improve_reward(slot(0), best, [best]).source != start.source
