"""The paper's own trainer: soft actor-critic of Stable-Baselines3 (extra `sb3`), on PyTorch.

The library learns in simulations of ours, and what it has learnt is handed out as the plain policy
that all trainers return, so that it is measured as theirs are.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from numpy.typing import NDArray
from stable_baselines3 import SAC
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecEnv

from robomore.errors import TrainingDiverged
from robomore.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from robomore.training.policy import MLPPolicy
from robomore.training.settings import SB3Settings
from robomore.training.threads import ONE_THREAD
from robomore.training.trainer import PROGRESS_SECONDS, Progress, VectorEnvProtocol, whole_rounds

log = logging.getLogger(__name__)

_MEMORY = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Arrays of the library's replay memory."""


class SB3:
    """Trains with Stable-Baselines3; see `Trainer`."""

    def __init__(self, settings: SB3Settings) -> None:
        for name, value in ONE_THREAD.items():
            os.environ.setdefault(name, value)
        torch.set_num_threads(1)
        self.settings = settings

    def prepare(self, observation_size: int, action_size: int) -> None:
        """Nothing is compiled."""

    def train(
        self,
        environment: VectorEnvProtocol,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> list[MLPPolicy]:
        """Train for `steps` control steps, rounded down to whole rounds; see `Trainer.train`.

        Raises:
            InputError: fewer steps than one round, or a round that the simulations do not divide.
            TrainingDiverged: a weight is no longer a finite number.
        """
        steps = whole_rounds(self.settings, environment, steps) * self.settings.train_freq
        run = _Run(self.settings, environment, steps, seed)
        if checkpoint is not None:
            run.restore(checkpoint)
        run.learn(progress)
        if checkpoint is not None:
            run.save(checkpoint)
        return [run.policy()]


class _Run:
    """A training under way."""

    def __init__(
        self, settings: SB3Settings, environment: VectorEnvProtocol, steps: int, seed: int
    ) -> None:
        self.environment = environment
        self.steps = steps
        asked = settings.discount
        discount = environment.discount if asked is None else asked
        self.model = SAC(
            "MlpPolicy",
            LibraryEnvironment(environment, seed),
            learning_rate=settings.rate,
            # A memory that is never filled is the same at any size.
            buffer_size=min(settings.buffer_size, steps + environment.num_envs),
            learning_starts=settings.learning_starts,
            batch_size=settings.batch_size,
            tau=settings.tau,
            gamma=discount,
            train_freq=(settings.train_freq // environment.num_envs, "step"),
            gradient_steps=settings.gradient_steps,
            ent_coef=f"auto_{settings.init_alpha}",
            target_entropy="auto" if settings.target_entropy is None else settings.target_entropy,
            policy_kwargs={"net_arch": list(settings.hidden), "n_critics": settings.critics},
            seed=seed,
            device="cpu",
        )
        self.model.set_logger(Logger(folder=None, output_formats=[]))
        # As in `loop`: a checkpoint is of this training if these agree.
        identity = [
            type(self).__module__,
            dataclasses.asdict(settings),
            seed,
            environment.num_envs,
            [environment.observation_size, environment.action_size],
            discount,
        ]
        self.identity = json.loads(json.dumps(identity))

    def learn(self, progress: Progress | None) -> None:
        """Go on until the budget is used up."""
        model, told, updates = self.model, time.monotonic(), self.model._n_updates

        def after_step(*_: Any) -> bool:
            nonlocal told, updates
            if model._n_updates > updates:
                updates = model._n_updates
                self._check()
            if progress is not None and time.monotonic() - told > PROGRESS_SECONDS:
                told = time.monotonic()
                progress(model.num_timesteps)
            return True

        try:
            model.learn(
                self.steps - model.num_timesteps, callback=after_step, reset_num_timesteps=False
            )
        except ValueError:
            # PyTorch's distributions refuse numbers that are not finite.
            self._check()
            raise
        self._check()
        if progress is not None:
            progress(model.num_timesteps)

    def _check(self) -> None:
        if not all(torch.isfinite(each).all() for each in self.model.policy.parameters()):
            raise TrainingDiverged(
                f"training diverged after {self.model.num_timesteps} steps: a weight is no longer "
                "a finite number; the rewards may be too large"
            )

    def policy(self) -> MLPPolicy:
        """Return the deterministic policy."""
        actor = self.model.actor
        linear = [part for part in actor.latent_pi if isinstance(part, torch.nn.Linear)]
        layers = [*linear, actor.mu]
        return MLPPolicy(
            tuple(layer.weight.detach().numpy().T.copy() for layer in layers),
            tuple(layer.bias.detach().numpy().copy() for layer in layers),
        )

    def save(self, folder: Path) -> None:
        """Leave everything in `folder`."""
        model, memory = self.model, self.model.replay_buffer
        filled = memory.buffer_size if memory.full else memory.pos
        arrays = {f"memory {name}": getattr(memory, name)[:filled] for name in _MEMORY}
        for name, tensor in self._tensors().items():
            arrays[name] = tensor.detach().numpy()
        for optimiser, name in self._optimisers():
            for index, state in optimiser.state_dict()["state"].items():
                for part, tensor in state.items():
                    arrays[f"adam {name} {index} {part}"] = tensor.numpy()
        kind, keys, *place = np.random.get_state(legacy=True)  # noqa: NPY002  # the library draws there
        arrays["random numpy"] = keys
        arrays["random torch"] = torch.get_rng_state().numpy()
        arrays["observation"] = model._last_obs
        facts = {
            "identity": self.identity,
            "steps": model.num_timesteps,
            "updates": model._n_updates,
            "memory_position": memory.pos,
            "random_numpy": [kind, *place],
            "random_actions": model.action_space.np_random.bit_generator.state,
        }
        save_checkpoint(folder, Checkpoint(facts, arrays, self.environment.state()))

    def restore(self, folder: Path) -> None:
        """Continue from `folder` if it holds this training within its budget."""
        found = load_checkpoint(folder)
        if found is None:
            return
        facts, arrays = found.facts, found.arrays
        if facts["identity"] != self.identity:
            log.warning("the checkpoint in %s is of another training; starting anew", folder)
            return
        if facts["steps"] > self.steps:
            log.info("the checkpoint in %s is past %d steps; starting anew", folder, self.steps)
            return
        model, memory = self.model, self.model.replay_buffer
        with torch.no_grad():
            for name, tensor in self._tensors().items():
                tensor.copy_(torch.from_numpy(arrays[name]))
        for optimiser, name in self._optimisers():
            states: dict[int, dict[str, Any]] = {}
            for key, array in arrays.items():
                kind, _, rest = key.partition(f" {name} ")
                if kind == "adam":
                    index, _, part = rest.partition(" ")
                    states.setdefault(int(index), {})[part] = torch.from_numpy(array)
            groups = optimiser.state_dict()["param_groups"]
            optimiser.load_state_dict({"state": states, "param_groups": groups})
        filled = len(arrays["memory rewards"])
        for name in _MEMORY:
            getattr(memory, name)[:filled] = arrays[f"memory {name}"]
        memory.full = filled == memory.buffer_size
        memory.pos = facts["memory_position"]
        model.num_timesteps, model._n_updates = facts["steps"], facts["updates"]
        model._last_obs = arrays["observation"]
        model._last_episode_starts = np.zeros(self.environment.num_envs, np.bool_)
        self.environment.restore(found.environment)
        kind, *place = facts["random_numpy"]
        np.random.set_state((kind, arrays["random numpy"], *place))  # noqa: NPY002
        torch.set_rng_state(torch.from_numpy(arrays["random torch"]))
        model.action_space.np_random.bit_generator.state = facts["random_actions"]

    def _tensors(self) -> dict[str, Any]:
        weights = {f"weights {name}": it for name, it in self.model.policy.state_dict().items()}
        return weights | {"log_entropy_weight": self.model.log_ent_coef}

    def _optimisers(self) -> list[tuple[Any, str]]:
        model = self.model
        return [
            (model.actor.optimizer, "actor"),
            (model.critic.optimizer, "critic"),
            (model.ent_coef_optimizer, "entropy"),
        ]


class LibraryEnvironment(VecEnv):  # type: ignore[misc]  # its package is not there when types are checked
    """Our simulations as the library wants them, one control step at a time."""

    def __init__(self, environment: VectorEnvProtocol, seed: int) -> None:
        self._environment = environment
        self._first_seed = seed
        sizes = environment.observation_size, environment.action_size
        super().__init__(
            environment.num_envs,
            Box(-np.inf, np.inf, (sizes[0],), np.float32),
            Box(-1.0, 1.0, (sizes[1],), np.float32),
        )

    def reset(self) -> NDArray[np.float32]:
        return self._environment.reset(self._first_seed).astype(np.float32)

    def step_async(self, actions: NDArray[np.float32]) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Any, ...]:
        transition = self._environment.step(self._actions)
        ended = transition.terminated | transition.truncated
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(ended).tolist():
            told[i] = {
                "terminal_observation": transition.final_observation[i].astype(np.float32),
                # Values go on after such an end.
                "TimeLimit.truncated": not transition.terminated[i],
            }
        observation = transition.observation.astype(np.float32)
        return observation, transition.reward.astype(np.float32), ended, told

    def close(self) -> None:
        """Nothing is held open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return `None` for each simulation: there is nothing but what is asked for at first."""
        if attr_name != "render_mode":
            raise AttributeError(attr_name)
        return [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise AttributeError(attr_name)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **more: Any) -> Any:
        raise AttributeError(method_name)

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        return [False] * self.num_envs
