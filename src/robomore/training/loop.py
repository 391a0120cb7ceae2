"""The off-policy loop that our algorithms share: act for a round, learn, keep checkpoints.

Acting, the replay buffer and everything random are NumPy's; learning is one compiled call a round.
A checkpoint holds exactly what the loop reads, so a continued training gives the same bits as one
that was never stopped.
"""

from __future__ import annotations

import dataclasses
import json
import math
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

import jax
import numpy as np
from numpy.typing import NDArray

from robomore.errors import TrainingDiverged
from robomore.training.checkpoint import Checkpoint, checkpoint_of, save_checkpoint
from robomore.training.curve import CurveRecorder
from robomore.training.exploration_noise import ExplorationNoise
from robomore.training.gaussian import explore
from robomore.training.policy import MLPPolicy
from robomore.training.replay_buffer import ReplayBuffer
from robomore.training.rounds import train_in_rounds, whole_rounds
from robomore.training.settings import LoopSettings
from robomore.training.threads import use_one_thread
from robomore.training.trainer import Progress, TrainingEnv, TrainingResult

Layers = list[tuple[NDArray[np.float32], NDArray[np.float32]]]
"""Weight and bias of each layer of a stochastic policy, normalisation folded in. The last layer
gives the Gaussian's mean and the logarithm of its standard deviation."""

CHECKPOINT_GROWTH = 1.1
"""A policy is put aside, and the scale of rewards is measured anew, each time that the steps have
grown by this factor. No budget enters this schedule, so a continued training returns the policies
of one that was never stopped."""


class OffPolicyTrainer(ABC):
    """A `Trainer` that consists of this loop and an algorithm; see `TrainingRun` for the loop.

    An algorithm is a tree of arrays (`begin`), and what one round of learning makes of it
    (`learn`).
    """

    def __init__(self, settings: Any) -> None:
        """Prepare JAX for this process.

        Args:
            settings: of the algorithm, a kind of `LoopSettings`.
        """
        use_one_thread()
        self.settings = settings

    @abstractmethod
    def begin(
        self, random: np.random.Generator, observation_size: int, action_size: int
    ) -> tuple[Any, Layers]:
        """Return the tree before any learning, and its policy."""

    @abstractmethod
    def learn(
        self, state: Any, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[Any, Layers, dict[str, float]]:
        """Return the tree after one round of learning, its policy, and losses by series name.

        Args:
            state: the tree, which may be overwritten.
            rows: (gradient steps, batch, width) from `ReplayBuffer.sample`.
            noise: (gradient steps, 2, batch, action_size), standard normal.
            done: gradient steps done before.
        """

    def prepare(self, observation_size: int, action_size: int) -> None:
        """Compile the first round of learning for a robot; see `Trainer.prepare`.

        A program that an algorithm has for later rounds (CrossQ, once batch renormalisation sets
        in) is not among it: each training that comes so far compiles it for itself.
        """
        shape = self.settings.gradient_steps, self.settings.batch_size
        observed = _observed(self.settings, observation_size)
        state, _ = self.begin(np.random.default_rng(0), observed, action_size)
        rows = np.zeros((*shape, 2 * observed + action_size + 2), np.float32)
        noise = np.zeros((shape[0], 2, shape[1], action_size), np.float32)
        self.learn(state, rows, noise, done=0)

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
        run = TrainingRun(self, self.settings, environment, seed)
        return train_in_rounds(run, steps, checkpoint, progress)


class TrainingRun:
    """A training under way, in an environment that starts anew or from a checkpoint."""

    def __init__(
        self,
        algorithm: OffPolicyTrainer,
        settings: LoopSettings,
        environment: TrainingEnv,
        seed: int,
    ) -> None:
        sizes = _observed(settings, environment.observation_size), environment.action_size
        self.algorithm = algorithm
        self.settings = settings
        self.environment = environment
        self.random = np.random.default_rng(seed)
        self.buffer = ReplayBuffer(settings.buffer_size, *sizes, environment.num_envs)
        self.state, self.layers = algorithm.begin(self.random, *sizes)
        self.average = self.layers
        self.earlier: list[Layers] = []  # policies put aside
        self.curve = CurveRecorder(environment.num_envs)
        self.num_deterministic = int(settings.deterministic_env_fraction * environment.num_envs)
        longest = settings.max_noise_repeat
        self.noise = ExplorationNoise(longest, environment.num_envs, environment.action_size)
        self.observation = environment.reset(seed)
        self.observed = sizes[0]
        self.steps = 0
        self.updates = 0
        # A checkpoint is of this training if these agree; JSON, so that they compare as stored.
        identity = [
            type(algorithm).__name__,
            dataclasses.asdict(settings),
            seed,
            environment.num_envs,
            sizes,
        ]
        self.identity = json.loads(json.dumps(identity))

    def advance(self) -> None:
        """Act for one round, then learn from what the buffer holds."""
        before = self.steps
        for _ in range(self.settings.train_freq):
            self._act()
        self.steps += self.settings.train_freq * self.environment.num_envs
        losses: dict[str, float] = {}
        if self.steps >= self.settings.learning_starts:
            grown = bool(before) and _growths(self.steps) > _growths(before)
            if self.settings.normalize_rewards and (grown or not self.updates):
                self.buffer.measure_scale(self.settings.gamma)
            losses = self._learn()
            if grown:
                others = self.settings.num_eval_checkpoints - 1
                self.earlier = [*self.earlier, self.average][-others:] if others else []
        self.curve.note_round(self.steps, losses, self.environment)

    def _act(self) -> None:
        if self.updates:
            noise = self.noise.draw(self.random)
            noise[: self.num_deterministic] = 0
            action = explore(self.layers, self.observation[:, : self.observed], noise)
        else:
            shape = self.environment.num_envs, self.environment.action_size
            action = self.random.uniform(-1, 1, shape).astype(np.float32)
        transition = self.environment.step(action)
        self.buffer.add(self.observation, action, transition)
        self.curve.note_step(transition)
        self.observation = transition.observation

    def _learn(self) -> dict[str, float]:
        settings = self.settings
        shape = settings.gradient_steps, settings.batch_size
        rows = self.buffer.sample(self.random, shape, settings.gamma, settings.n_steps)
        noise = self.random.standard_normal(
            (shape[0], 2, shape[1], self.environment.action_size), np.float32
        )
        self.state, self.layers, losses = self.algorithm.learn(
            self.state, rows, noise, self.updates
        )
        finite = all(np.isfinite(weight).all() for weight, _ in self.layers)
        if not finite or not np.isfinite(list(losses.values())).all():
            said = ", ".join(f"{name} {value:g}" for name, value in losses.items())
            raise TrainingDiverged(
                f"training diverged after {self.steps} steps: a weight or a loss is no longer a "
                f"finite number ({said}); the rewards may be too large"
            )
        self.updates += settings.gradient_steps
        self._track_average()
        return losses

    def _track_average(self) -> None:
        """Average over a window that grows with training, so that it serves every budget."""
        window = self.settings.policy_ema_fraction * self.updates / self.settings.gradient_steps
        if window <= 1:
            self.average = self.layers
            return
        self.average = [
            (old[0] + (new[0] - old[0]) / window, old[1] + (new[1] - old[1]) / window)
            for old, new in zip(self.average, self.layers, strict=True)
        ]

    def policies(self) -> tuple[MLPPolicy, ...]:
        """Return deterministic policies, each an average over some rounds; the latest last."""
        size = self.environment.observation_size
        return tuple(deterministic(layers, size) for layers in (*self.earlier, self.average))

    def result(self) -> TrainingResult:
        """Return what the training has given so far."""
        return TrainingResult(self.policies(), self.curve.curve(self.steps, self.environment))

    def save(self, folder: Path) -> None:
        """Leave a checkpoint in `folder`."""
        curve, arrays = self.curve.state()
        arrays |= {f"state{i}": leaf for i, leaf in enumerate(jax.tree.leaves(self.state))}
        for name, layers in self._policies().items():
            for i, (weight, bias) in enumerate(layers):
                arrays |= {f"{name}_weight{i}": weight, f"{name}_bias{i}": bias}
        arrays["observation"] = self.observation
        arrays |= self.buffer.state() | self.noise.state()
        facts = {
            "identity": self.identity,
            "steps": self.steps,
            "updates": self.updates,
            "earlier": len(self.earlier),
            "curve": curve,
            "buffer_position": self.buffer.position,
            "random": self.random.bit_generator.state,
        }
        save_checkpoint(folder, Checkpoint(facts, arrays, self.environment.state()))

    def restore(self, folder: Path, most_steps: int) -> None:
        """Continue from `folder` if it holds this training after at most `most_steps`."""
        found = checkpoint_of(folder, self.identity, most_steps)
        if found is None:
            return
        facts, arrays = found.facts, found.arrays
        leaves, tree = jax.tree.flatten(self.state)
        self.state = jax.tree.unflatten(tree, [arrays[f"state{i}"] for i in range(len(leaves))])
        indices = range(len(self.layers))

        def stored(name: str) -> Layers:
            return [(arrays[f"{name}_weight{i}"], arrays[f"{name}_bias{i}"]) for i in indices]

        self.layers, self.average = stored("layers"), stored("average")
        self.earlier = [stored(f"earlier{i}") for i in range(facts["earlier"])]
        self.observation = arrays["observation"]
        self.buffer.restore(arrays, facts["buffer_position"])
        self.noise.restore(arrays)
        self.steps, self.updates = facts["steps"], facts["updates"]
        self.random.bit_generator.state = facts["random"]
        self.curve.restore(facts["curve"], arrays)
        self.environment.restore(found.environment)

    def _policies(self) -> dict[str, Layers]:
        """Everything that has the form of a policy, by the name it is stored under."""
        earlier = {f"earlier{i}": layers for i, layers in enumerate(self.earlier)}
        return {"layers": self.layers, "average": self.average} | earlier


def _growths(steps: int) -> int:
    return int(math.log(steps) / math.log(CHECKPOINT_GROWTH))


def _observed(settings: LoopSettings, observation_size: int) -> int:
    return min(settings.observed or observation_size, observation_size)


def deterministic(layers: Layers, observation_size: int = 0) -> MLPPolicy:
    """Return the policy that acts by the Gaussian's mean.

    Args:
        layers: of the stochastic policy.
        observation_size: of what the policy will be given, if that is more than the networks see;
            it ignores the rest.
    """
    *inner, (weight, bias) = layers
    size = len(bias) // 2
    layers = [*inner, (weight[:, :size], bias[:size])]
    first, bias = layers[0]
    ignored = np.zeros((max(0, observation_size - len(first)), first.shape[1]), np.float32)
    layers[0] = np.concatenate([first, ignored]), bias
    return MLPPolicy(
        tuple(np.array(weight) for weight, _ in layers),
        tuple(np.array(bias) for _, bias in layers),
    )
