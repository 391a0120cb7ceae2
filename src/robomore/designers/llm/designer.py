"""The designer of the paper: a language model that proposes, is corrected, and improves."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from robomore.designers.llm.history import HistorySettings
from robomore.designers.llm.parsing import (
    BadReply,
    Check,
    errors,
    in_words,
    parse_morphology,
    parse_reward,
)
from robomore.designers.llm.prompting import (
    morphology_schema,
    render,
    render_prompt,
    repair_message,
)
from robomore.errors import InputError, ProposalFailed
from robomore.llm import BudgetedClient, Exchange, Message, Request, Sampling
from robomore.rewards.check import check_reward
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Slot

Pictures = Callable[[Evaluation], Sequence[bytes]]
"""Draws a measured design as PNG files: its body, and a strip of how it moves."""

_LONGEST_ECHO = 12_000
"""Characters of a bad reply that are sent back with its faults."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class LLMSettings:
    """How a language model is used as a designer.

    Attributes:
        diversity: Diversity Reflection: each proposal is shown all earlier ones. Without it,
            proposals are independent samples, and may repeat each other.
        repairs: how often a bad reply is answered with its faults before the slot is given up.
        history: how much of what was measured is shown when improving.
        sampling: of the model.
    """

    diversity: bool = True
    repairs: int = 3
    history: HistorySettings = field(default_factory=HistorySettings)
    sampling: Sampling = field(default_factory=Sampling)

    def __post_init__(self) -> None:
        """Raises `InputError` for values that make no sense."""
        if self.repairs < 0:
            raise InputError(f"repairs = {self.repairs} is less than 0")
        if self.history.tokens < 0:
            raise InputError(f"history tokens = {self.history.tokens} is less than 0")
        _ = self.history.turns


class LLMDesigner:
    """Proposes with a language model (see `Designer`). May be called from several threads.

    A reply is looked up before it is paid for, and judged once: what was found wrong with it stays
    found, so that a resumed run goes the same way.
    """

    name = "llm"

    def __init__(
        self,
        task: Task,
        client: BudgetedClient,
        settings: LLMSettings | None = None,
        *,
        objective: str = "efficiency",
        check: Check = check_reward,
        rehearse: Check | None = None,
        pictures: Pictures | None = None,
    ) -> None:
        """Make a designer for one task.

        Args:
            task: what is to be done.
            client: the model, the log and the budget.
            settings: how the model is used.
            objective: what the search compares.
            check: reads the text of a reward.
            rehearse: tries a reward out on moving bodies; `None` to skip that.
            pictures: draws what is to be improved, for a model that can see.
        """
        self.reflects = (settings or LLMSettings()).diversity
        self.provenance = f"Proposed by a language model: {client.model.name}."
        self._task = task
        self._client = client
        self._settings = settings or LLMSettings()
        self._objective = objective
        self._check = check
        self._rehearse = rehearse
        self._pictures = pictures
        # Only asking goes on side by side. Up to Python 3.12 `ast.parse` fails now and then when
        # two threads parse (cpython#106905), and rehearsals should not slow each other down.
        self._alone = threading.Lock()
        self._schema = morphology_schema(task)

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a body unlike all `earlier` ones (paper, Alg. 1: ProposeMorphology)."""
        shown = earlier if self._settings.diversity else ()
        prompt = self._prompt("morphology", earlier=shown)
        return self._morphology(slot, prompt, shown)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return a reward unlike all `earlier` ones (paper, Alg. 1: ProposeReward)."""
        shown = earlier if self._settings.diversity else ()
        prompt = self._prompt("reward", earlier=shown)
        return self._reward(slot, prompt, shown)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return a body to try with `best`'s reward (paper, Alg. 1: ImproveMorphology)."""
        source = best.design.reward.source
        tried = [e.design.morphology for e in (best, *history) if e.design.reward.source == source]
        return self._morphology(slot, self._improvement("morphology", best, history), tried)

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return a reward to try on `best`'s body (paper, Alg. 1: ImproveReward)."""
        body = best.design.morphology.parameters
        tried = [
            e.design.reward for e in (best, *history) if e.design.morphology.parameters == body
        ]
        return self._reward(slot, self._improvement("reward", best, history), tried)

    def _improvement(
        self, half: str, best: Evaluation, history: Sequence[Evaluation]
    ) -> list[Message]:
        role, question = self._prompt(
            f"improve-{half}", best=best, measured=history, settings=self._settings.history
        )
        with self._alone:
            images = tuple(self._pictures(best)) if self._pictures else ()
        if not images:
            return [role, question]
        return [role, Message("user", f"{question.text}\n\n{render('pictures')}", images)]

    def _prompt(self, kind: str, **given: Any) -> list[Message]:
        with self._alone:
            return render_prompt(self._task, kind, objective=self._objective, **given)

    def _morphology(
        self, slot: Slot, prompt: Sequence[Message], taken: Sequence[Morphology]
    ) -> Morphology:
        def read(exchange: Exchange) -> Morphology:
            return parse_morphology(exchange.reply, self._task, taken, exchange.truncated)

        return self._repaired(slot, prompt, read, self._schema)

    def _reward(self, slot: Slot, prompt: Sequence[Message], taken: Sequence[Reward]) -> Reward:
        def read(exchange: Exchange) -> Reward:
            reward = parse_reward(exchange.reply, taken, exchange.truncated, self._check)
            # A rehearsal measures time and may judge differently tomorrow: it is believed once.
            if exchange.validation_errors is None and self._rehearse is not None:
                found = self._rehearse(reward.source)
                # What is merely doubtful is said once; then the model knows what it wants.
                if errors(found) or (found and not exchange.repair and self._settings.repairs):
                    raise BadReply(in_words(found))
            return reward

        return self._repaired(slot, prompt, read, None)

    def _repaired(
        self,
        slot: Slot,
        prompt: Sequence[Message],
        read: Callable[[Exchange], T],
        schema: dict[str, Any] | None,
    ) -> T:
        """Ask until a reply can be read, telling its faults each time (bounded)."""
        messages = (*prompt[:-1], _afresh(prompt[-1], slot.attempt))
        for repair in range(self._settings.repairs + 1):
            request = Request(slot, repair, messages, schema, self._settings.sampling)
            exchange = self._client.ask(request)
            try:
                if exchange.validation_errors:
                    raise BadReply(exchange.validation_errors)
                with self._alone:
                    proposal = read(exchange)
            except BadReply as bad:
                self._client.set_errors(exchange, bad.faults)
                faults = bad.faults
            else:
                self._client.set_errors(exchange, ())
                return proposal
            # Some providers refuse an empty turn.
            echo = exchange.reply[:_LONGEST_ECHO] or "(no answer)"
            messages = (*messages, Message("assistant", echo), repair_message(faults))
        raise ProposalFailed(
            f"no usable {slot.kind} in {self._settings.repairs + 1} answers; wrong with the last: "
            + "; ".join(faults)
        )


def _afresh(question: Message, attempt: int) -> Message:
    """Return the question of a fresh attempt: to the very same one, some say the very same."""
    if not attempt:
        return question
    return replace(question, text=f"{question.text}\n\n{render('fresh', attempt=str(attempt + 1))}")
