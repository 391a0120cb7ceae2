"""Does a trainer keep what a `Trainer` promises? Tried in a tiny environment without physics."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from robomore.errors import InputError
from robomore.testing.probe_env import ProbeEnv
from robomore.training.curve import check_curve
from robomore.training.policy import MOST_BYTES, MOST_LAYERS, MLPPolicy
from robomore.training.trainer import Trainer, TrainingResult
from robomore.types import Curve

SEED = 3


def check_trainer(make: Callable[[], Trainer], steps: int = 1_024) -> None:
    """Check that a trainer keeps its contract (`robomore.training.trainer.Trainer`).

    Args:
        make: makes the trainer; called several times. Give it small networks and an early start of
            learning, or this takes long and learns nothing.
        steps: control steps of the longest training, over the 4 environments of a `ProbeEnv`. A
            quarter of them has to be enough for the trainer to begin learning.

    Raises:
        AssertionError: with one sentence on what is wrong.
    """
    make().prepare(ProbeEnv.observation_size, ProbeEnv.action_size)
    _check_too_few_steps(make())
    told: list[int] = []
    result = make().train(ProbeEnv(), steps, SEED, progress=told.append)
    _check_result(result)
    _check_progress(told, steps)
    _check_seed(make, steps, result)
    with TemporaryDirectory(prefix="robomore-") as folder:
        _check_continuation(make, steps, result, Path(folder))


def same_result(one: TrainingResult, other: TrainingResult) -> bool:
    """Return whether two trainings gave the same policies, to the bit, and the same curve."""
    policies = one.policies, other.policies
    first, second = ([a for p in some for a in (*p.weights, *p.biases)] for some in policies)
    return (
        len(first) == len(second)
        and all(a.tobytes() == b.tobytes() for a, b in zip(first, second, strict=True))
        and one.curve == other.curve
    )


def _check_too_few_steps(trainer: Trainer) -> None:
    few = ProbeEnv.num_envs - 1
    try:
        trainer.train(ProbeEnv(), few, SEED)
    except InputError:
        return
    raise AssertionError(
        f"a budget of {few} steps is less than one step of each environment; `train` has to refuse "
        "it with an InputError"
    )


def _check_result(result: TrainingResult) -> None:
    assert isinstance(result, TrainingResult), "`train` has to return a TrainingResult"
    assert result.policies, "`train` has to return at least one policy"
    for policy in result.policies:
        _check_policy(policy)
    if result.curve is not None:
        _check_curve(result.curve)


def _check_policy(policy: MLPPolicy) -> None:
    assert isinstance(policy, MLPPolicy), "a policy has to be an MLPPolicy"
    for array in (*policy.weights, *policy.biases):
        assert array.dtype == np.float32, f"a policy's arrays have to be float32, not {array.dtype}"
        assert np.isfinite(array).all(), "a policy's numbers have to be finite"
    size = policy.weights[0].shape[0]
    assert size == ProbeEnv.observation_size, (
        f"the policy takes {size} numbers where an observation has {ProbeEnv.observation_size}"
    )
    try:
        MLPPolicy.from_bytes(policy.to_bytes())
    except ValueError as error:
        raise AssertionError(
            f"a policy has to be read back from its file, which has {MOST_LAYERS} layers and "
            f"{MOST_BYTES // 2**20} MiB at most: {error}"
        ) from None
    actions = policy.act(np.zeros((3, size)))
    assert actions.shape == (3, ProbeEnv.action_size), (
        f"the policy gives actions of the shape {actions.shape} for 3 observations, "
        f"not {(3, ProbeEnv.action_size)}"
    )


def _check_curve(curve: Curve) -> None:
    try:
        check_curve(curve)
    except ValueError as error:
        raise AssertionError(str(error)) from None


def _check_progress(told: list[int], steps: int) -> None:
    assert told, "`progress` has to be called at least once, at the end of training"
    assert told == sorted(told), f"`progress` may not go back: {told}"
    assert 0 < told[-1] <= steps, (
        f"`progress` ended at {told[-1]} control steps; the budget was {steps}"
    )


def _check_seed(make: Callable[[], Trainer], steps: int, result: TrainingResult) -> None:
    again = make().train(ProbeEnv(), steps, SEED)
    assert same_result(result, again), "the same seed has to give the same result to the bit"
    other = make().train(ProbeEnv(), steps, SEED + 1)
    assert not same_result(result, other), "another seed has to give another result"


def _check_continuation(
    make: Callable[[], Trainer], steps: int, result: TrainingResult, folder: Path
) -> None:
    for part in (math.ceil(steps / 4), steps // 2):
        make().train(ProbeEnv(), part, SEED, folder)
    told: list[int] = []
    continued = make().train(ProbeEnv(), steps, SEED, folder, told.append)
    assert same_result(result, continued), (
        "a training that was continued from a checkpoint has to give what it gives in one go, to "
        "the bit"
    )
    _check_progress(told, steps)
    shorter = make().train(ProbeEnv(), steps // 2, SEED)
    past = make().train(ProbeEnv(), steps // 2, SEED, folder)
    assert same_result(shorter, past), (
        "a checkpoint that is past the budget must not be continued from"
    )
