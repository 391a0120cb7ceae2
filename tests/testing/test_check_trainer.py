"""The trainers' contract check: it accepts a trainer that keeps the contract, and no other."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robomore.errors import InputError
from robomore.testing.trainers import check_trainer
from robomore.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from robomore.training.policy import MLPPolicy
from robomore.training.trainer import Progress, Trainer, TrainingEnv, TrainingResult
from robomore.types import Curve


class RandomSearch:
    """Tries random actions, and returns a policy that always does the rewarded ones' mean."""

    def prepare(self, observation_size: int, action_size: int) -> None:
        pass

    def train(
        self,
        environment: TrainingEnv,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> TrainingResult:
        rounds = steps // environment.num_envs
        if not rounds:
            raise InputError("too few steps")
        random = np.random.default_rng(seed)
        done, liked = 0, np.zeros(environment.action_size)
        found = load_checkpoint(checkpoint) if checkpoint else None
        if found and found.facts["seed"] == seed and found.facts["done"] <= rounds:
            done, liked = found.facts["done"], found.arrays["liked"]
            random.bit_generator.state = found.facts["random"]
            self.restore(environment, found)
        else:
            environment.reset(seed)
        while done < rounds:
            actions = random.uniform(-1, 1, (environment.num_envs, environment.action_size))
            liked = liked + environment.step(actions).reward @ actions
            done += 1
            if progress is not None:
                progress(done * environment.num_envs)
        if progress is not None:
            progress(done * environment.num_envs)
        if checkpoint is not None:
            facts = {"seed": seed, "done": done, "random": random.bit_generator.state}
            save_checkpoint(checkpoint, Checkpoint(facts, {"liked": liked}, environment.state()))
        weight = np.zeros((environment.observation_size, environment.action_size), np.float32)
        return TrainingResult((MLPPolicy((weight,), ((liked / steps).astype(np.float32),)),))

    def restore(self, environment: TrainingEnv, found: Checkpoint) -> None:
        environment.restore(found.environment)


def test_a_trainer_that_keeps_the_contract_passes() -> None:
    check_trainer(RandomSearch)


def changed(change: Callable[[TrainingResult], Any]) -> type[RandomSearch]:
    """Return a trainer whose results are changed."""

    class Changed(RandomSearch):
        def train(self, *args: Any, **more: Any) -> TrainingResult:
            result: TrainingResult = change(super().train(*args, **more))
            return result

    return Changed


def policy(weight: Any, bias: Any) -> Callable[[TrainingResult], TrainingResult]:
    arrays = np.asarray(weight), np.asarray(bias)
    return lambda result: TrainingResult((MLPPolicy((arrays[0],), (arrays[1],)),))


class NeverRefuses(RandomSearch):
    def train(self, environment: TrainingEnv, steps: int, seed: int, *a: Any) -> TrainingResult:
        return super().train(environment, max(steps, 4), seed, *a)


class Seedless(RandomSearch):
    def train(
        self, environment: TrainingEnv, steps: int, seed: int, *a: Any, **b: Any
    ) -> TrainingResult:
        return super().train(environment, steps, 0, *a, **b)


class Restless(RandomSearch):
    """Another seed each time."""

    trainings = 0

    def train(
        self, environment: TrainingEnv, steps: int, seed: int, *a: Any, **b: Any
    ) -> TrainingResult:
        Restless.trainings += 1
        return super().train(environment, steps, seed + Restless.trainings, *a, **b)


class ForgetsTheEnvironment(RandomSearch):
    """Continues its own numbers in an environment that starts anew."""

    def restore(self, environment: TrainingEnv, found: Checkpoint) -> None:
        environment.reset(99)


class GoesBack(RandomSearch):
    def train(
        self, environment: TrainingEnv, steps: int, seed: int, *a: Any, **b: Any
    ) -> TrainingResult:
        result = super().train(environment, steps, seed, *a, **b)
        if "progress" in b:
            b["progress"](1)
        return result


class TakesLonger(RandomSearch):
    def train(
        self, environment: TrainingEnv, steps: int, seed: int, *a: Any, **b: Any
    ) -> TrainingResult:
        return super().train(environment, 2 * steps if steps > 4 else steps, seed, *a, **b)


def deep(result: TrainingResult) -> TrainingResult:
    """Return a policy of one layer too many."""
    square = np.eye(2, dtype=np.float32), np.zeros(2, np.float32)
    layers = [*[square] * 16, (np.zeros((2, 1), np.float32), np.zeros(1, np.float32))]
    return TrainingResult((MLPPolicy(*(tuple(part) for part in zip(*layers, strict=True))),))


FLAT = np.zeros((2, 1), np.float32)

BROKEN: dict[str, tuple[type[Trainer], str]] = {
    "never refuses": (NeverRefuses, "InputError"),
    "no result": (changed(lambda result: [*result.policies]), "TrainingResult"),
    "no policy": (changed(lambda result: TrainingResult(())), "at least one policy"),
    "double": (changed(policy(np.zeros((2, 1)), FLAT[0])), "float32"),
    "not finite": (changed(policy(FLAT, np.float32([np.nan]))), "finite"),
    "layers": (changed(deep), "16 layers and 64 MiB at most"),
    "inputs": (changed(policy(np.zeros((3, 1), np.float32), FLAT[0])), "takes 3 numbers"),
    "outputs": (
        changed(policy(np.zeros((2, 2), np.float32), np.float32([0, 0]))),
        "actions of the shape",
    ),
    "curve": (
        changed(lambda result: TrainingResult(result.policies, Curve((2, 1), {}))),
        "do not rise",
    ),
    "seedless": (Seedless, "another seed"),
    "restless": (Restless, "same seed"),
    "forgets": (ForgetsTheEnvironment, "continued from a checkpoint"),
    "goes back": (GoesBack, "may not go back"),
    "takes longer": (TakesLonger, "the budget was"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_trainer_is_found_out(name: str) -> None:
    make, said = BROKEN[name]
    with pytest.raises(AssertionError, match=said):
        check_trainer(make)
