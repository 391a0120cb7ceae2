from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import pytest
from synthetic import evaluation

from robomore.designers.offline.designer import OfflineDesigner
from robomore.designers.offline.reward_composition import RewardComposition, read
from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.envs.reward_text import reward_function
from robomore.tasks.registry import TASKS
from robomore.types import Evaluation, Morphology, Reward, Slot, Status

HOPPER = TASKS["hopper"]
BODY = RewardSampler(HOPPER, 0).body
HUMAN = Morphology(HOPPER.reference)
PLAIN = {"forward_speed": 2.0, "alive": 0.8, "effort": 0.05}
TRIES = 40


def slot(index: int) -> Slot:
    return Slot("fine", "reward", 0, index)


def written(weights: Mapping[str, float]) -> Reward:
    return Reward(RewardComposition(weights).source(BODY))


def measured(
    weights: Mapping[str, float] = PLAIN,
    terms: Mapping[str, float] | None = None,
    fitness: float = 5.0,
    **behaviour: float,
) -> Evaluation:
    return evaluation(
        HOPPER, HUMAN, written(weights), fitness, behaviour=behaviour, terms=terms or {}
    )


def improved(best: Evaluation, history: list[Evaluation] | None = None) -> list[RewardComposition]:
    """What many branches would try next."""
    designer = OfflineDesigner(HOPPER, 2)
    made = []
    for index in range(TRIES):
        reward = designer.improve_reward(slot(index), best, history or [best])
        recipe = read(reward.source, BODY)
        assert recipe is not None and recipe.lead is not None
        made.append(recipe)
    return made


def share(recipes: list[RewardComposition], name: str, above: float = 0.0) -> float:
    return sum(recipe.weights.get(name, 0.0) > above for recipe in recipes) / len(recipes)


def test_a_term_that_drowns_the_task_is_damped() -> None:
    balanced = {"forward_speed": 2.0, "alive": 0.3, "effort": -0.1}
    drowned = {"forward_speed": 0.2, "alive": 0.8, "effort": -0.1}
    calm = improved(measured(terms=balanced, forward_speed_m_s=1.0))
    cured = improved(measured(terms=drowned, forward_speed_m_s=1.0))
    lowered = [r.weights.get("alive", 0.0) < 0.8 for r in cured]
    usual = [r.weights.get("alive", 0.0) < 0.8 for r in calm]
    assert sum(lowered) > 2 * sum(usual)


def test_a_robot_that_falls_gets_more_for_standing() -> None:
    falls = improved(measured(fell_share=1.0, forward_speed_m_s=1.0))
    stands = improved(measured(fell_share=0.0, forward_speed_m_s=1.0))

    def steadier(recipes: list[RewardComposition]) -> float:
        names = ("upright", "lean", "riding_height")
        return share(recipes, "alive", 0.8) + sum(share(recipes, name) for name in names)

    assert steadier(falls) > steadier(stands) + 0.3


def test_a_robot_that_stands_still_is_got_going() -> None:
    still = improved(measured(fell_share=0.0, forward_speed_m_s=0.05))
    runs = improved(measured(fell_share=0.0, forward_speed_m_s=3.0))
    changes = (("activity",), ("early_progress",), ("forward_speed", 3.0))
    moved = sum(share(still, *change) for change in changes)
    before = sum(share(runs, *change) for change in changes)
    assert moved > before + 0.3


def test_a_policy_that_rattles_is_smoothed() -> None:
    rattles = improved(measured(mean_jerk=1.5, forward_speed_m_s=1.0))
    smooth = improved(measured(mean_jerk=0.2, forward_speed_m_s=1.0))
    assert share(rattles, "jerkiness") > share(smooth, "jerkiness") + 0.1


def test_terms_are_taken_over_from_rewards_that_did_well() -> None:
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
        history.append(evaluation(HOPPER, HUMAN, reward, 1.0))
    assert max(Counter(e.design.reward.source for e in history).values()) == 1


def test_a_strangers_reward_is_improved_too() -> None:
    designer = OfflineDesigner(HOPPER, 2)
    best = evaluation(HOPPER, HUMAN, Reward(HOPPER.reward), 5.0)
    failed = evaluation(HOPPER, HUMAN, Reward("def"), status=Status.INVALID_REWARD)
    reward = designer.improve_reward(slot(0), best, [best, failed])
    recipe = read(reward.source, BODY)
    assert recipe is not None
    assert recipe.lead is not None


def test_a_change_depends_on_its_arguments_alone() -> None:
    best = measured(forward_speed_m_s=1.0)
    first = OfflineDesigner(HOPPER, 2)
    made = [first.improve_reward(slot(index), best, [best]) for index in range(6)]
    second = OfflineDesigner(HOPPER, 2)
    assert [second.improve_reward(slot(i), best, [best]) for i in reversed(range(6))] == made[::-1]
    assert len({reward.source for reward in made}) > 3


@pytest.mark.parametrize("task", TASKS)
def test_rewards_of_all_tasks_can_be_improved(task: str) -> None:
    known = TASKS[task]
    designer = OfflineDesigner(known, 0)
    start = designer.propose_reward(Slot("coarse", "reward", 0, 0), ())
    best = evaluation(known, Morphology(known.reference), start, 2.0)
    assert designer.improve_reward(slot(0), best, [best]).source != start.source
