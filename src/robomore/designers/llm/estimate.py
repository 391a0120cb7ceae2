"""What a run will ask of a model, before the first request is sent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robomore.designers.llm.designer import LLMSettings
from robomore.designers.llm.prompting import render_prompt
from robomore.llm.tokens import estimate_prompt
from robomore.tasks.task import Task

_REWARD_TOKENS = 600
_REPAIRS = 0.25
"""Bad answers that are expected for each good one."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A forecast, from the lengths of the prompts and usual lengths of answers.

    Attributes:
        requests: answers needed, some of them after a repair.
        input_tokens: of all prompts.
        output_tokens: of all answers, without what a reasoning model thinks.
        cost: in US dollars; `None` where no price is known.
    """

    requests: int
    input_tokens: int
    output_tokens: int
    cost: float | None

    def __str__(self) -> str:
        price = "no known price" if self.cost is None else f"about ${self.cost:.2f}"
        return (
            f"about {self.requests} requests, {self.input_tokens:,} tokens in and "
            f"{self.output_tokens:,} out (more if the model thinks aloud), {price}"
        )


def estimate(
    task: Task,
    settings: LLMSettings,
    price: Callable[[int, int], float | None],
    *,
    morphologies: int,
    rewards: int,
    branches: int,
    cycles: int,
) -> Estimate:
    """Forecast what a run asks of a model.

    Args:
        task: whose prompts are measured.
        settings: of the designer.
        price: of so many tokens in and out, in US dollars (`ChatModel.cost`).
        morphologies: proposals of the coarse stage.
        rewards: proposals of the coarse stage.
        branches: of the fine stage.
        cycles: of each branch; each asks for one body and one reward.
    """
    answers = {"morphology": 40 + 15 * len(task.parameters), "reward": _REWARD_TOKENS}
    prompts = {half: estimate_prompt(render_prompt(task, half)) for half in answers}
    sent = received = 0
    for half, count in (("morphology", morphologies), ("reward", rewards)):
        # Proposal number i is shown the i before it.
        shown = count * (count - 1) // 2 * answers[half] if settings.diversity else 0
        sent += count * prompts[half] + shown
        received += count * answers[half]
    steps = branches * cycles
    for half in answers:
        sent += steps * (prompts[half] + settings.history.tokens)
        received += steps * answers[half]
    requests = morphologies + rewards + 2 * steps
    # A repair sends the prompt again, with the bad answer and its faults.
    repairs = _REPAIRS if settings.repairs else 0.0
    input_tokens = round(sent * (1 + repairs) + received * repairs)
    output_tokens = round(received * (1 + repairs))
    return Estimate(
        round(requests * (1 + repairs)),
        input_tokens,
        output_tokens,
        price(input_tokens, output_tokens),
    )
