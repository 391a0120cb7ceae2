"""The part of an evaluation that runs untrusted code, always in a sandboxed process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec

from robomore.envs.vector_env import VectorEnv
from robomore.evaluation.request import Request, Training
from robomore.rewards.continuation import check_continuation
from robomore.rewards.load import load_reward
from robomore.tasks.registry import carried_task
from robomore.text import to_json
from robomore.training.settings import make_trainer, settings_from

POLICIES = "policy-*.npz"
"""Files in the scratch folder that carry the trained policies out, the latest last by name."""


def train(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Train one design and leave its policies in `scratch`.

    Args:
        payload: an encoded `Request`.
        scratch: the only folder that may be written to (and the checkpoint's, if one is asked for).
        report: is told the control steps done.

    Returns:
        An encoded `Training`.

    Raises:
        InvalidReward, RewardFailed, UnstableSimulation: the reasons are the design's.
    """
    request = msgspec.json.decode(payload, type=Request)
    job = request.job
    task = carried_task(job.task, request.task)
    parameters = job.design.morphology.parameters
    settings = settings_from(job.trainer)
    reward = load_reward(job.design.reward.source)
    check_continuation(task, parameters, reward)
    environment = VectorEnv(
        task,
        parameters,
        settings.num_envs,
        reward,
        episode_seconds=settings.episode_seconds,
        replace_rk4=settings.replace_rk4,
    )
    done = job.steps

    def told(steps: int) -> None:
        nonlocal done
        done = steps
        report(steps)

    trained = make_trainer(job.trainer).train(
        environment,
        job.steps,
        job.seed,
        checkpoint=Path(request.checkpoint) if request.checkpoint else None,
        progress=told,
    )
    if environment.reward_runner is not None:
        environment.reward_runner.check()  # an interruption would have found it
    for index, policy in enumerate(trained.policies):
        policy.save(scratch / POLICIES.replace("*", f"{index:02}"))
    return to_json(
        Training(done, environment.reward_statistics(), environment.notes(), trained.curve)
    )
