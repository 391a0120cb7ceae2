"""The paper's own trainer: soft actor-critic of Stable-Baselines3 (extra `sb3`), on PyTorch.

The library learns in our environments. Its policy is returned as the plain arrays that all trainers
return, so that it is measured as theirs are.
"""

from __future__ import annotations

import dataclasses
import json
import os
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
from robomore.training.checkpoint import Checkpoint, checkpoint_of, save_checkpoint
from robomore.training.curve import CurveRecorder
from robomore.training.policy import MLPPolicy
from robomore.training.rounds import train_in_rounds, whole_rounds
from robomore.training.settings import SB3Settings
from robomore.training.threads import ONE_THREAD
from robomore.training.trainer import Progress, TrainingEnv, TrainingResult

_BUFFER = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Arrays of the library's replay buffer."""

_SERIES = {
    "train/critic_loss": "loss/critic",
    "train/actor_loss": "loss/actor",
    "train/ent_coef": "alpha",
}
"""What the library logs, and how the learning curve calls it."""


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
        environment: TrainingEnv,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> TrainingResult:
        """Train for `steps` control steps, rounded down to whole rounds; see `Trainer.train`."""
        steps = whole_rounds(self.settings, environment, steps)
        run = _Run(self.settings, environment, steps, seed)
        return train_in_rounds(run, steps, checkpoint, progress)


class _Run:
    """A training under way."""

    def __init__(
        self, settings: SB3Settings, environment: TrainingEnv, budget: int, seed: int
    ) -> None:
        self.environment = environment
        self.curve = CurveRecorder(environment.num_envs)
        self.model = SAC(
            "MlpPolicy",
            LibraryEnvironment(environment, seed, self.curve),
            learning_rate=settings.learning_rate,
            # A buffer that is never filled is the same at any size.
            buffer_size=min(settings.buffer_size, budget + environment.num_envs),
            learning_starts=settings.learning_starts,
            batch_size=settings.batch_size,
            tau=settings.tau,
            gamma=settings.gamma,
            train_freq=settings.train_freq,
            gradient_steps=settings.gradient_steps,
            ent_coef=f"auto_{settings.init_alpha}",
            target_entropy="auto" if settings.target_entropy is None else settings.target_entropy,
            policy_kwargs={"net_arch": list(settings.net_arch), "n_critics": settings.n_critics},
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
        ]
        self.identity = json.loads(json.dumps(identity))

    @property
    def steps(self) -> int:
        """Control steps done, over all environments."""
        steps: int = self.model.num_timesteps
        return steps

    def advance(self) -> None:
        """Act for one round, then learn."""
        model, updates = self.model, self.model._n_updates
        try:
            # One round; the library counts the budget from the very first step.
            model.learn(1, log_interval=None, reset_num_timesteps=False)
        except ValueError:
            # PyTorch's distributions refuse numbers that are not finite.
            self._check()
            raise
        losses = {}
        if model._n_updates > updates:
            self._check()
            said = model.logger.name_to_value
            losses = {series: float(said[name]) for name, series in _SERIES.items()}
        self.curve.note_round(self.steps, losses, self.environment)

    def _check(self) -> None:
        if not all(torch.isfinite(each).all() for each in self.model.policy.parameters()):
            raise TrainingDiverged(
                f"training diverged after {self.steps} steps: a weight is no longer "
                "a finite number; the rewards may be too large"
            )

    def result(self) -> TrainingResult:
        """Return what the training has given so far; its policy is the deterministic one."""
        actor = self.model.actor
        linear = [part for part in actor.latent_pi if isinstance(part, torch.nn.Linear)]
        layers = [*linear, actor.mu]
        policy = MLPPolicy(
            tuple(layer.weight.detach().numpy().T.copy() for layer in layers),
            tuple(layer.bias.detach().numpy().copy() for layer in layers),
        )
        return TrainingResult((policy,), self.curve.curve(self.steps, self.environment))

    def save(self, folder: Path) -> None:
        """Leave everything in `folder`."""
        model, buffer = self.model, self.model.replay_buffer
        filled = buffer.buffer_size if buffer.full else buffer.pos
        arrays = {f"buffer {name}": getattr(buffer, name)[:filled] for name in _BUFFER}
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
        curve, curve_arrays = self.curve.state()
        facts = {
            "identity": self.identity,
            "steps": model.num_timesteps,
            "updates": model._n_updates,
            "curve": curve,
            "buffer_position": buffer.pos,
            "random_numpy": [kind, *place],
            "random_actions": model.action_space.np_random.bit_generator.state,
        }
        save_checkpoint(folder, Checkpoint(facts, arrays | curve_arrays, self.environment.state()))

    def restore(self, folder: Path, most_steps: int) -> None:
        """Continue from `folder` if it holds this training after at most `most_steps`."""
        found = checkpoint_of(folder, self.identity, most_steps)
        if found is None:
            return
        facts, arrays = found.facts, found.arrays
        model, buffer = self.model, self.model.replay_buffer
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
        filled = len(arrays["buffer rewards"])
        for name in _BUFFER:
            getattr(buffer, name)[:filled] = arrays[f"buffer {name}"]
        buffer.full = filled == buffer.buffer_size
        buffer.pos = facts["buffer_position"]
        model.num_timesteps, model._n_updates = facts["steps"], facts["updates"]
        model._last_obs = arrays["observation"]
        model._last_episode_starts = np.zeros(self.environment.num_envs, np.bool_)
        self.curve.restore(facts["curve"], arrays)
        self.environment.restore(found.environment)
        kind, *place = facts["random_numpy"]
        np.random.set_state((kind, arrays["random numpy"], *place))  # noqa: NPY002
        torch.set_rng_state(torch.from_numpy(arrays["random torch"]))
        model.action_space.np_random.bit_generator.state = facts["random_actions"]

    def _tensors(self) -> dict[str, Any]:
        weights = {f"weights {name}": it for name, it in self.model.policy.state_dict().items()}
        return weights | {"log_alpha": self.model.log_ent_coef}

    def _optimisers(self) -> list[tuple[Any, str]]:
        model = self.model
        return [
            (model.actor.optimizer, "actor"),
            (model.critic.optimizer, "critic"),
            (model.ent_coef_optimizer, "alpha"),
        ]


class LibraryEnvironment(VecEnv):  # type: ignore[misc]  # its package is not there when types are checked
    """Our environments as the library wants them, one control step at a time."""

    def __init__(
        self, environment: TrainingEnv, seed: int, curve: CurveRecorder | None = None
    ) -> None:
        self._environment = environment
        self._first_seed = seed
        self._curve = curve
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
        if self._curve is not None:
            self._curve.note_step(transition)
        ended = transition.terminated | transition.truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(ended).tolist():
            infos[i] = {
                "terminal_observation": transition.final_observation[i].astype(np.float32),
                # Values go on after such an end.
                "TimeLimit.truncated": not transition.terminated[i],
            }
        observation = transition.observation.astype(np.float32)
        return observation, transition.reward.astype(np.float32), ended, infos

    def close(self) -> None:
        """Nothing is held open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return `None` for each environment: the library asks for the render mode alone."""
        if attr_name != "render_mode":
            raise AttributeError(attr_name)
        return [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise AttributeError(attr_name)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **more: Any) -> Any:
        raise AttributeError(method_name)

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        return [False] * self.num_envs
