"""The crawler: any number of legs and segments is a robot, for each part of the program."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from exhaustive import more_of
from llm.loopback import KEY, serve
from robomore.designers import LanguageModel, Replay
from robomore.designers.llm.designer import LLMSettings
from robomore.designers.llm.prompting import morphology_schema
from robomore.designers.offline.designer import OfflineDesigner
from robomore.designers.offline.plausibility_prior import PlausibilityPrior
from robomore.envs.compile import compile_model, model_volume
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InvalidMorphology
from robomore.experiment import run
from robomore.llm import connect
from robomore.llm.providers import COMPATIBLE_KEY
from robomore.options import with_options
from robomore.rewards.load import load_reward
from robomore.runs import load_run
from robomore.search import METHODS
from robomore.settings import preset, with_method
from robomore.tasks import get_task
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Morphology, Slot
from tiny import TINY, numbers

CRAWLER = get_task("crawler")
STRUCTURES = list(itertools.product(range(3, 9), range(1, 4)))


def crawler(legs: float, segments: float) -> tuple[float, ...]:
    return (legs, segments, *CRAWLER.reference[2:])


@pytest.mark.parametrize(("legs", "segments"), STRUCTURES)
def test_each_structure_is_simulated_and_measured(legs: int, segments: int) -> None:
    parameters = crawler(legs, segments)
    model = compile_model(CRAWLER, parameters)
    assert (model.nu, model.nbody) == (legs * segments, 2 + legs * segments)
    assert CRAWLER.volume(parameters) == pytest.approx(model_volume(model), rel=1e-6)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, i) for i in range(model.nu)]
    assert names[0] == "hip_0" and len(set(names)) == model.nu

    env = VectorEnv(CRAWLER, parameters, 2, load_reward(CRAWLER.reward))
    env.reset(0)
    for _ in range(20):
        transition = env.step(np.zeros((2, legs * segments), np.float32))
    assert not transition.terminated.any(), "it stands"


def test_a_count_is_a_whole_number() -> None:
    with pytest.raises(InvalidMorphology, match=r"legs = 4\.5 is a count; give a whole number"):
        CRAWLER.check(crawler(4.5, 2))
    schema = morphology_schema(CRAWLER)["properties"]["parameters"]["properties"]
    assert schema["legs"] == {"type": "integer", "minimum": 3, "maximum": 8}
    space = UnitSpace(CRAWLER)
    values = space.values(np.random.default_rng(0).random((200, space.size)))
    assert space.valid(values).all()
    assert {tuple(row) for row in values[:, :2].tolist()} == set(STRUCTURES)
    assert [CRAWLER.names[i] for i in np.flatnonzero(space.radii)] == [
        "torso_radius",
        "upper_radius",
        "middle_radius",
        "lower_radius",
    ]


def test_the_offline_designer_proposes_several_structures() -> None:
    designer = OfflineDesigner(CRAWLER, 0)
    found: list[Morphology] = []
    for number in range(6):
        slot = Slot("coarse", "morphology", (number,))
        found.append(designer.propose_morphology(slot, found))
        CRAWLER.check(found[-1].parameters)
    assert len({one.parameters[:2] for one in found}) > 2
    reward = load_reward(designer.propose_reward(Slot("coarse", "reward", (0,)), ()).source)
    for structure in ((3, 1), (8, 3)):
        env = VectorEnv(CRAWLER, crawler(*structure), 1, reward)
        env.reset(0)
        assert np.isfinite(env.step(np.ones((1, env.action_size), np.float32)).reward).all()


def test_structures_are_rated_by_what_they_are() -> None:
    """Rows of other structures in the same call change nothing."""
    prior = PlausibilityPrior(CRAWLER)
    rows = np.array([crawler(*structure) for structure in STRUCTURES], dtype=float)
    together = prior.log_efficiency(rows)
    assert np.isfinite(together).all()
    alone = [PlausibilityPrior(CRAWLER).log_efficiency(row[None])[0] for row in rows]
    np.testing.assert_allclose(together, alone)


def said(legs: float, segments: int) -> tuple[str, str]:
    values = dict(zip(CRAWLER.names, crawler(legs, segments), strict=True))
    return "say", json.dumps({"parameters": values, "description": f"{legs} legs"})


REWARD = (
    "say",
    "```python\ndef _get_rew(self, x_velocity, action):\n"
    "    return x_velocity, {'speed': x_velocity}\n```",
)


def test_a_model_proposes_structures_and_its_exchanges_are_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(COMPATIBLE_KEY, KEY)
    answers = [said(4.5, 2), said(4, 2), said(6, 3), REWARD, said(5, 1), REWARD]
    settings = with_method(TINY, options={"morphologies": 2})
    with serve(*answers) as (url, script):
        model = connect("toy", base_url=url)
        chosen = LanguageModel(model, LLMSettings(repairs=1), server=url)
        done = run(
            "crawler", settings, designer=chosen, executor="untrained", out=tmp_path / "told"
        )
        assert "legs = 4.5 is a count" in json.dumps(script.seen[1])
    assert done.champion
    tried = {e.design.morphology.parameters[:2] for e in done.evaluations}
    assert {(4.0, 2.0), (6.0, 3.0), (5.0, 1.0)} <= tried
    again = run(
        "crawler",
        settings,
        designer=Replay(tmp_path / "told"),
        executor="untrained",
        out=tmp_path / "replayed",
    )
    assert numbers(again.folder) == numbers(done.folder)
    assert load_run(again.folder).champion == done.champion


@pytest.mark.parametrize(
    "method", more_of([n for n in METHODS if n not in ("reference", "given")], "cmaes", "genetic")
)
def test_all_methods_search_over_structures(method: str, tmp_path: Path) -> None:
    settings = with_options(preset("smoke"), method=method, evaluations=10)
    done = run("crawler", settings, executor="untrained", out=tmp_path, seed=1)
    structures = {one.design.morphology.parameters[:2] for one in done.evaluations}
    assert structures <= set(STRUCTURES)
    assert len(structures) > 1 or method in ("slim-reference", "eureka")


@pytest.mark.exhaustive
def test_it_is_trained_to_a_champion(tmp_path: Path) -> None:
    done = run("crawler", "smoke", out=tmp_path / "run", workers=2)
    assert done.champion and done.champion.evaluations[0].fitness is not None
    assert all(one.ok for one in done.evaluations), [one.diagnosis for one in done.evaluations]
