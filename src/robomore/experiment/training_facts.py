"""What a designer may know of how designs are trained, from the settings of a run."""

from __future__ import annotations

from robomore.designers.llm.training_facts import TrainingFacts
from robomore.settings import RunSettings
from robomore.tasks import Task
from robomore.training.settings import settings_from
from robomore.training.tuned import resolve


def training_facts(settings: RunSettings, task: Task) -> TrainingFacts:
    """Return how the designs of a search are trained on the robot of `task`."""
    resolved = resolve(settings.trainer, task)
    trainer = settings_from(resolved)
    return TrainingFacts(
        algorithm=resolved.name,
        steps=settings.candidate.steps,
        episodes=settings.candidate.episodes,
        gamma=getattr(trainer, "gamma", None),
        num_envs=trainer.num_envs,
        episode_seconds=trainer.episode_seconds,
        normalizes_reward=getattr(trainer, "normalize_rewards", False),
    )
