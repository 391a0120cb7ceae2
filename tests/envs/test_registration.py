"""Tasks as ordinary Gymnasium environments."""

from __future__ import annotations

import copy
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from paper import PAPER
from robomore.envs import opengl
from robomore.envs.registration import ENVIRONMENTS, EPISODE_STEPS, register
from robomore.errors import InputError, InvalidMorphology, InvalidReward
from robomore.tasks import TASKS
from robomore.tasks.registry import PAPER_TASKS


def test_every_task_is_registered_once() -> None:
    assert set(ENVIRONMENTS.values()) == set(PAPER)
    assert all(task.episode_steps == EPISODE_STEPS for task in PAPER_TASKS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        register()
        register()
    assert {f"robomore/{name}-v0" for name in ENVIRONMENTS} <= set(gymnasium.registry)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_passes_gymnasiums_own_check(name: str) -> None:
    made = gymnasium.make(f"robomore/{name}-v0")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*Box observation space.*infinity")
        check_env(made.unwrapped, skip_render_check=True)
    assert made.spec is not None and made.spec.max_episode_steps == EPISODE_STEPS


def test_parameters_and_rewards_are_taken_in_every_form() -> None:
    def double(self: Any, x_velocity: float, action: Any) -> tuple[float, dict[str, float]]:
        return 2 * x_velocity, {}

    text = "def _get_rew(self, x_velocity, action):\n    return 3 * x_velocity, {'m': math.pi}\n"
    reference = TASKS["swimmer"].reference
    named = dict(zip(TASKS["swimmer"].names, reference, strict=True))
    found = []
    for options in (
        {"reward": "def _get_rew(self, v, a):\n    return v, {}\n"},
        {"reward": double, "parameters": list(reference)},
        {"reward": text, "parameters": named},
    ):
        made = gymnasium.make("robomore/Swimmer-v0", **options)
        made.reset(seed=0)
        found.append(made.step(np.ones(2, np.float32))[1])
    assert found == pytest.approx([found[0], 2 * found[0], 3 * found[0]])
    assert found[0] != 0


def test_the_reference_is_the_default() -> None:
    ours = gymnasium.make("robomore/Swimmer-v0")
    theirs = gymnasium.make("Swimmer-v5")
    assert np.array_equal(ours.reset(seed=3)[0], theirs.reset(seed=3)[0])
    action = np.array([0.3, -0.7])
    assert ours.step(action)[1] == pytest.approx(theirs.step(action)[1], abs=1e-9)


def test_mistakes_are_named() -> None:
    with pytest.raises(InvalidMorphology, match="'tall'"):
        gymnasium.make("robomore/Ant-v0", parameters="tall")
    with pytest.raises(InvalidMorphology, match="takes 10"):
        gymnasium.make("robomore/Ant-v0", parameters=[1.0])
    with pytest.raises(InvalidMorphology, match="the parameters are 1; give 10 numbers"):
        gymnasium.make("robomore/Ant-v0", parameters=1)
    with pytest.raises(InvalidReward, match="does not parse"):
        gymnasium.make("robomore/Ant-v0", reward="def _get_rew(")
    with pytest.raises(InvalidReward, match="_get_rew"):
        gymnasium.make("robomore/Ant-v0", reward="x = 1")


@pytest.mark.parametrize("order", ["gymnasium, robomore", "robomore, gymnasium"])
def test_tasks_are_known_in_whichever_order_both_are_imported(order: str, tmp_path: Path) -> None:
    about = tmp_path / "own-0.1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: own\nVersion: 0.1\n")
    (about / "entry_points.txt").write_text("[robomore.tasks]\nhill-dog = own_hill_dog:TASK\n")
    (tmp_path / "own_hill_dog.py").write_text(
        "import dataclasses\n"
        "from robomore.tasks.swimmer import SWIMMER\n"
        "TASK = dataclasses.replace(SWIMMER, id='hill-dog', episode_steps=2)\n"
    )
    code = (
        f"import sys, {order}\n"
        "assert 'robomore/Ant-v0' in gymnasium.registry\n"
        "assert 'own_hill_dog' not in sys.modules and 'mujoco' not in sys.modules\n"
        "env = gymnasium.make('robomore/HillDog-v0')\n"
        "env.reset(seed=0)\n"
        "print([env.step(env.action_space.sample())[3] for _ in range(2)])\n"
    )
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[False, True]\n"


def test_a_picture_without_opengl_is_one_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL"):
        monkeypatch.setenv(name, "")
    monkeypatch.setattr(sys, "platform", "linux")
    made = gymnasium.make("robomore/Swimmer-v0", render_mode="rgb_array")
    made.reset(seed=0)
    opengl.ensure_opengl.cache_clear()
    monkeypatch.setattr(opengl, "_works", lambda platform: False)
    with pytest.raises(InputError, match="neither EGL nor OSMesa works; apt install libosmesa6"):
        made.render()
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    opengl.ensure_opengl.cache_clear()
    with pytest.raises(InputError, match="MUJOCO_GL=glfw does not work; set it to egl"):
        made.render()
    monkeypatch.setenv("MUJOCO_GL", "")
    opengl.ensure_opengl.cache_clear()
    monkeypatch.setattr(opengl, "_works", lambda platform: platform == "osmesa")
    opengl.ensure_opengl()
    assert os.environ["MUJOCO_GL"] == "osmesa"
    opengl.ensure_opengl.cache_clear()


def test_importing_the_module_is_cheap_and_enough() -> None:
    code = (
        "import sys, gymnasium, robomore.envs.registration\n"
        "assert 'mujoco' not in sys.modules and 'jax' not in sys.modules\n"
        "gymnasium.make('robomore/Swimmer-v0')\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_a_reward_reads_what_a_step_leaves_out_and_counts_steps() -> None:
    text = (
        "def _get_rew(self, x_velocity, action):\n"
        "    momentum = float(self.model.body_mass[1:].sum() * self.data.subtree_linvel[1, 0])\n"
        "    return momentum, {'energy': self.data.energy[1], 'steps': self.training_steps}\n"
    )
    env = gymnasium.make("robomore/HalfCheetah-v0", reward=text)
    env.reset(seed=0)
    given = [env.step(np.ones(6))[1] for _ in range(5)]
    again = copy.deepcopy(env)
    assert np.abs(given).min() > 0 and env.unwrapped.data.energy[1] > 0
    assert env.unwrapped.training_steps == 5 and again.unwrapped.training_steps == 0


def test_a_window_without_a_screen_is_an_error_and_no_abort(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    shown = gymnasium.make("robomore/Hopper-v0", render_mode="human")
    with pytest.raises(InputError, match="rgb_array"):
        shown.reset()
