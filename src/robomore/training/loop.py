"""The off-policy loop that every algorithm here shares: act for a round, learn, keep checkpoints.

Acting, the replay memory and everything random are NumPy's; learning is one compiled call a
round. What a checkpoint holds is exactly what the loop reads, so continuing gives the same bits
as never having stopped.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import math
import time
from pathlib import Path
from typing import Any, Protocol

import jax
import numpy as np
from numpy.typing import NDArray

from robomore.errors import TrainingDiverged
from robomore.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from robomore.training.gaussian import explore
from robomore.training.policy import MLPPolicy
from robomore.training.replay import Replay
from robomore.training.trainer import PROGRESS_SECONDS, Progress, VectorEnvProtocol, whole_rounds

log = logging.getLogger(__name__)

Layers = list[tuple[NDArray[np.float32], NDArray[np.float32]]]
"""Weight and bias of each layer of a stochastic policy, normalisation folded in. The last layer
gives the Gaussian's mean and the logarithm of its deviation."""

SNAPSHOT_GROWTH = 1.1
"""A policy is put aside each time that the steps have grown by this factor, which is a schedule
that no budget enters: continuing gives the policies of never having stopped."""


class LoopSettings(Protocol):
    """What the loop reads of an algorithm's settings (`robomore.training.settings`)."""

    @property
    def train_freq(self) -> int: ...
    @property
    def gradient_steps(self) -> int: ...
    @property
    def learning_starts(self) -> int: ...
    @property
    def buffer_size(self) -> int: ...
    @property
    def batch_size(self) -> int: ...
    @property
    def discount(self) -> float | None: ...
    @property
    def n_step(self) -> int: ...
    @property
    def deterministic_env_fraction(self) -> float | None: ...
    @property
    def policy_ema_fraction(self) -> float: ...
    @property
    def snapshots(self) -> int: ...


class Learning(Protocol):
    """The algorithm proper: a tree of arrays, and what one round of learning makes of it."""

    def begin(
        self, random: np.random.Generator, observation_size: int, action_size: int
    ) -> tuple[Any, Layers]:
        """Return the tree before any learning, and its policy."""
        ...

    def learn(
        self, learner: Any, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[Any, Layers, dict[str, float]]:
        """Return the tree after one round of learning, its policy, and losses by name.

        Args:
            learner: the tree, which may be overwritten.
            rows: (updates, batch, width) from `Replay.sample`; the last column is what a value
                after the row is worth at its start.
            noise: (updates, 2, batch, actions), standard normal.
            done: gradient steps done before.
        """
        ...


def train(
    learning: Learning,
    settings: Any,
    environment: VectorEnvProtocol,
    steps: int,
    seed: int,
    checkpoint: Path | None,
    progress: Progress | None,
) -> list[MLPPolicy]:
    """Train for `steps` control steps, rounded down to whole rounds; see `Trainer.train`.

    Raises:
        InputError: fewer steps than one round, or a round that the simulations do not divide.
        TrainingDiverged: a weight or a loss is no longer a finite number.
    """
    rounds = whole_rounds(settings, environment, steps)
    run = Run(learning, settings, environment, seed)
    if checkpoint is None or not run.restore(checkpoint, rounds):
        run.observation = environment.reset(seed)
    told = time.monotonic()
    while run.rounds < rounds:
        run.advance()
        if progress is not None and time.monotonic() - told > PROGRESS_SECONDS:
            told = time.monotonic()
            progress(run.steps)
    if progress is not None:
        progress(run.steps)
    if checkpoint is not None:
        run.save(checkpoint)
    return run.policies()


class Run:
    """A training under way."""

    def __init__(
        self, learning: Learning, settings: Any, environment: VectorEnvProtocol, seed: int
    ) -> None:
        sizes = environment.observation_size, environment.action_size
        self.learning = learning
        self.settings: LoopSettings = settings
        self.environment = environment
        self.random = np.random.default_rng(seed)
        self.replay = Replay(settings.buffer_size, *sizes, environment.num_envs)
        self.learner, self.layers = learning.begin(self.random, *sizes)
        self.average = self.layers
        self.snapshots: list[Layers] = []
        share = settings.deterministic_env_fraction
        self.quiet = int(
            (environment.deterministic_env_fraction if share is None else share)
            * environment.num_envs
        )
        self.observation = np.zeros((environment.num_envs, sizes[0]))
        self.rounds = 0
        self.updates = 0
        # A checkpoint is of this training if these agree; JSON, so that they compare as stored.
        identity = [
            type(learning).__name__,
            dataclasses.asdict(settings),
            seed,
            environment.num_envs,
            sizes,
            self.discount,
            self.quiet,
        ]
        self.identity = json.loads(json.dumps(identity))

    @property
    def steps(self) -> int:
        """Control steps done, over all simulations."""
        return self.rounds * self.settings.train_freq

    @property
    def discount(self) -> float:
        """What a reward one control step later is worth."""
        asked = self.settings.discount
        return self.environment.discount if asked is None else asked

    def advance(self) -> None:
        """Act for one round, then learn from what is remembered."""
        before = self.steps
        for _ in range(self.settings.train_freq // self.environment.num_envs):
            self._act()
        self.rounds += 1
        if self.steps >= self.settings.learning_starts:
            self._learn()
            if before and _growths(self.steps) > _growths(before):
                others = self.settings.snapshots - 1
                self.snapshots = [*self.snapshots, self.average][-others:] if others else []

    def _act(self) -> None:
        shape = self.environment.num_envs, self.environment.action_size
        if self.updates:
            noise = self.random.standard_normal(shape, np.float32)
            noise[: self.quiet] = 0
            action = explore(self.layers, self.observation, noise)
        else:
            action = self.random.uniform(-1, 1, shape).astype(np.float32)
        transition = self.environment.step(action)
        self.replay.add(self.observation, action, transition)
        self.observation = transition.observation

    def _learn(self) -> None:
        updates, batch = self.settings.gradient_steps, self.settings.batch_size
        rows = self.replay.sample(
            self.random, (updates, batch), self.discount, self.settings.n_step
        )
        noise = self.random.standard_normal(
            (updates, 2, batch, self.environment.action_size), np.float32
        )
        self.learner, self.layers, losses = self.learning.learn(
            self.learner, rows, noise, self.updates
        )
        finite = all(np.isfinite(weight).all() for weight, _ in self.layers)
        if not finite or not np.isfinite(list(losses.values())).all():
            said = ", ".join(f"{name} {value:g}" for name, value in losses.items())
            raise TrainingDiverged(
                f"training diverged after {self.steps} steps: a weight or a loss is no longer a "
                f"finite number ({said}); the rewards may be too large"
            )
        self.updates += updates
        self._track_average()

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

    def policies(self) -> list[MLPPolicy]:
        """Return deterministic policies, each an average over some rounds; the latest last."""
        return [deterministic(layers) for layers in (*self.snapshots, self.average)]

    def save(self, folder: Path) -> None:
        """Leave everything in `folder`."""
        arrays = {f"learner{i}": leaf for i, leaf in enumerate(jax.tree.leaves(self.learner))}
        for name, layers in self._policies().items():
            for i, (weight, bias) in enumerate(layers):
                arrays |= {f"{name}_weight{i}": weight, f"{name}_bias{i}": bias}
        arrays["observation"] = self.observation
        arrays["replay"] = self.replay.rows[: self.replay.size]
        arrays["replay_ended"] = self.replay.ended[: self.replay.size]
        facts = {
            "identity": self.identity,
            "rounds": self.rounds,
            "updates": self.updates,
            "snapshots": len(self.snapshots),
            "replay_position": self.replay.position,
            "random": self.random.bit_generator.state,
        }
        save_checkpoint(folder, Checkpoint(facts, arrays, self.environment.state()))

    def restore(self, folder: Path, rounds: int) -> bool:
        """Continue from `folder` if it holds this training after at most `rounds`."""
        found = load_checkpoint(folder)
        if found is None:
            return False
        facts, arrays = found.facts, found.arrays
        if facts["identity"] != self.identity:
            log.warning("the checkpoint in %s is of another training; starting anew", folder)
            return False
        if facts["rounds"] > rounds:
            log.info("the checkpoint in %s is past %d rounds; starting anew", folder, rounds)
            return False
        leaves, tree = jax.tree.flatten(self.learner)
        self.learner = jax.tree.unflatten(tree, [arrays[f"learner{i}"] for i in range(len(leaves))])
        indices = range(len(self.layers))

        def stored(name: str) -> Layers:
            return [(arrays[f"{name}_weight{i}"], arrays[f"{name}_bias{i}"]) for i in indices]

        self.layers, self.average = stored("layers"), stored("average")
        self.snapshots = [stored(f"snapshot{i}") for i in range(facts["snapshots"])]
        self.observation = arrays["observation"]
        self.replay.restore(arrays["replay"], arrays["replay_ended"], facts["replay_position"])
        self.rounds, self.updates = facts["rounds"], facts["updates"]
        self.random.bit_generator.state = facts["random"]
        self.environment.restore(found.environment)
        return True

    def _policies(self) -> dict[str, Layers]:
        """Everything that has the form of a policy, by the name it is stored under."""
        snapshots = {f"snapshot{i}": layers for i, layers in enumerate(self.snapshots)}
        return {"layers": self.layers, "average": self.average} | snapshots


def _growths(steps: int) -> int:
    return int(math.log(steps) / math.log(SNAPSHOT_GROWTH))


def deterministic(layers: Layers) -> MLPPolicy:
    """Return the policy that acts by the Gaussian's mean."""
    *inner, (weight, bias) = layers
    size = len(bias) // 2
    layers = [*inner, (weight[:, :size], bias[:size])]
    return MLPPolicy(
        tuple(np.array(weight) for weight, _ in layers),
        tuple(np.array(bias) for _, bias in layers),
    )
