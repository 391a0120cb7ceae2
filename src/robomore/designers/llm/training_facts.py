"""What trains the policies, in words for the prompts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TrainingFacts:
    """How each design is trained and measured.

    Attributes:
        algorithm: name of the training algorithm.
        steps: control steps of a full training, over all simulations together.
        episodes: episodes of the measurement.
        gamma: discount factor for each control step, `None` if the algorithm has no such setting.
        num_envs: simulations that run in parallel.
        episode_seconds: time after which training episodes are cut off, `None` for full episodes.
        normalizes_reward: whether the trainer rescales rewards.
    """

    algorithm: str
    steps: int
    episodes: int
    gamma: float | None = None
    num_envs: int | None = None
    episode_seconds: float | None = None
    normalizes_reward: bool = False

    def __str__(self) -> str:
        """Return one paragraph."""
        together = f", in {self.num_envs} simulations together" if self.num_envs else ""
        said = [
            f"A policy is trained from scratch for {self.steps:,} control steps{together}, with "
            f"the algorithm {self.algorithm} (deep reinforcement learning with an actor and "
            "critics)."
        ]
        if self.gamma is not None:
            ahead = round(1 / (1 - self.gamma)) if self.gamma < 1 else self.steps
            said.append(
                f"The discount factor is {self.gamma:g} for each control step, so that about "
                f"{ahead:,} control steps ahead count."
            )
        if self.episode_seconds is not None:
            said.append(
                f"Episodes of training are cut off after {self.episode_seconds:g} s; being cut "
                "off is not treated as an end."
            )
        if self.normalizes_reward:
            said.append(
                "The trainer normalises rewards: it clips rare extreme ones, subtracts their usual "
                "level and divides by the standard deviation of the discounted returns. So the "
                "sizes of terms matter beside each other alone, and a constant only where a fall "
                "ends the episode."
            )
        else:
            said.append("The trainer uses rewards as they are, without rescaling them.")
        said.append(
            f"The trained policy is then measured without exploration noise in {self.episodes:,} "
            "episodes with different random starts. Training is random: a design that is trained "
            "again with another seed gets another score."
        )
        return " ".join(said)
