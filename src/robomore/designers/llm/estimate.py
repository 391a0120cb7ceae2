"""Forecasts what a run asks of a language model, before the first request is sent."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from robomore.designers.llm.designer import LLMSettings
from robomore.designers.llm.prompting import render_prompt
from robomore.llm.tokens import estimate_prompt
from robomore.tasks.task import Task

_REWARD_TOKENS = 600
"""Usual length of a reward."""
_REPAIRS = 0.25
"""Expected invalid answers for each valid one."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A forecast from the lengths of the prompts and usual lengths of answers.

    The requests include repairs, and the output tokens leave out the thoughts of a reasoning model.
    The cost is in US dollars, or `None` if no price is known.
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
    proposals: Mapping[tuple[str, str], int],
) -> Estimate:
    """Forecast what a search asks of a model.

    Args:
        task: the task, whose prompts are measured.
        settings: settings of the designer.
        price: price of so many input and output tokens in US dollars (`ChatModel.cost`).
        proposals: number of proposals by action (`propose` or `improve`) and kind (`morphology` or
            `reward`), as in `Plan.proposals`.
    """
    answers = {"morphology": 40 + 15 * len(task.parameters), "reward": _REWARD_TOKENS}
    sent = received = 0
    for (action, kind), count in proposals.items():
        sent += count * estimate_prompt(render_prompt(task, kind))
        if action == "improve":
            sent += count * settings.history.tokens
        elif settings.diversity:
            # Each proposal is shown all earlier ones.
            sent += count * (count - 1) // 2 * answers[kind]
        received += count * answers[kind]
    # A repair sends the prompt again, with the invalid answer and its errors.
    repairs = _REPAIRS if settings.repairs else 0.0
    requests = round(sum(proposals.values()) * (1 + repairs))
    input_tokens = round(sent * (1 + repairs) + received * repairs)
    output_tokens = round(received * (1 + repairs))
    return Estimate(requests, input_tokens, output_tokens, price(input_tokens, output_tokens))
