from __future__ import annotations

from importlib.metadata import EntryPoint

import numpy as np
import pytest
from synthetic import evaluation

from robomore.designers import DESIGNERS, make_designer, registry
from robomore.designers.human import HumanDesigner
from robomore.designers.random import RandomDesigner
from robomore.errors import InputError
from robomore.tasks.registry import TASKS
from robomore.types import Slot


def slot(index: int, stage: str = "coarse") -> Slot:
    return Slot(stage, "morphology", 0, index)


@pytest.mark.parametrize("task", TASKS)
def test_human_is_the_reference(task: str) -> None:
    known = TASKS[task]
    designer = HumanDesigner(known)
    body, reward = designer.propose_morphology(slot(0), ()), designer.propose_reward(slot(0), ())
    assert body.parameters == known.reference
    assert reward.source == known.reward
    best = evaluation(known, body, reward)
    assert designer.improve_morphology(slot(1, "fine"), best, [best]) == body
    assert designer.improve_reward(slot(1, "fine"), best, [best]) == reward


@pytest.mark.parametrize("task", TASKS)
def test_random_bodies_are_valid_and_around_the_official_robot(task: str) -> None:
    known = TASKS[task]
    designer = RandomDesigner(known, 1)
    bodies = [designer.propose_morphology(slot(i), ()) for i in range(40)]
    drawn = np.array([known.check(body.parameters) for body in bodies])
    assert len({body.parameters for body in bodies}) == 40
    middle = np.median(drawn, axis=0)
    spread = np.maximum(np.abs(known.reference), 0.05)
    assert (np.abs(middle - known.reference) < spread).all()
    assert designer.propose_reward(slot(0), ()).source == known.reward


def test_the_deviation_sets_how_far_draws_go() -> None:
    def spread(deviation: float) -> float:
        designer = RandomDesigner(TASKS["swimmer"], 1, deviation)
        bodies = [designer.propose_morphology(slot(i), ()).parameters for i in range(30)]
        return float(np.std(bodies, axis=0).mean())

    assert spread(0.05) < 0.3 * spread(0.5)
    with pytest.raises(InputError, match="deviation = 0"):
        RandomDesigner(TASKS["swimmer"], 1, 0)


def test_random_draws_depend_on_seed_and_place_alone() -> None:
    swimmer = TASKS["swimmer"]
    first, second = RandomDesigner(swimmer, 1), RandomDesigner(swimmer, 1)
    forth = [first.propose_morphology(slot(i), ()) for i in range(4)]
    back = [second.propose_morphology(slot(i), ()) for i in reversed(range(4))]
    assert forth == back[::-1]
    assert RandomDesigner(swimmer, 2).propose_morphology(slot(0), ()) != forth[0]
    best = evaluation(swimmer, forth[0])
    improved = first.improve_morphology(slot(0, "fine"), best, [best])
    assert improved not in forth


@pytest.mark.parametrize("name", DESIGNERS)
def test_designers_are_made_by_name_and_say_that_no_llm_was_used(name: str) -> None:
    designer = make_designer(name, TASKS["swimmer"], 0, "fitness")
    assert designer.name == name
    assert designer.provenance.startswith("No LLM was used: ")


def test_an_unknown_designer_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="'ofline'; choose one of offline, human, random"):
        make_designer("ofline", TASKS["swimmer"], 0)


def entries(*found: EntryPoint) -> object:
    return lambda group: [entry for entry in found if entry.group == group]


def test_other_packages_add_designers(monkeypatch: pytest.MonkeyPatch) -> None:
    group = registry.GROUP
    other = EntryPoint("other", "robomore.designers.registry:_human", group)
    monkeypatch.setattr(registry, "entry_points", entries(other))
    registry.all_designers.cache_clear()
    assert make_designer("other", TASKS["swimmer"], 0).name == "human"
    for name, value, said in (
        ("human", "robomore.designers.registry:_human", "two designers are called 'human'"),
        ("broken", "robomore.no_such_module:make", "does not load"),
        ("text", "robomore.designers.registry:GROUP", "is no function"),
    ):
        monkeypatch.setattr(registry, "entry_points", entries(EntryPoint(name, value, group)))
        registry.all_designers.cache_clear()
        with pytest.raises(InputError, match=said):
            make_designer("nobody", TASKS["swimmer"], 0)
    registry.all_designers.cache_clear()
