"""The designer of the paper: a language model that proposes, corrects and improves."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from robomore.designers.llm.extraction import EMPTY
from robomore.designers.llm.history import CurveOf, HistorySettings
from robomore.designers.llm.parsing import (
    InvalidReply,
    RewardCheck,
    error_messages,
    messages,
    parse_morphology,
    parse_reward,
    unreadable,
)
from robomore.designers.llm.prompting import (
    morphology_schema,
    render,
    render_prompt,
    repair_message,
)
from robomore.designers.llm.training_facts import TrainingFacts
from robomore.errors import InputError, ModelUnavailable, ProposalFailed
from robomore.llm import BudgetedClient, Exchange, Message, Request, Sampling
from robomore.llm.trouble import Trouble, prompt_cut, trouble_with
from robomore.rewards.check import check_reward
from robomore.tasks.task import Task
from robomore.text import one_line
from robomore.types import Evaluation, Morphology, Reward, Slot

Pictures = Callable[[Evaluation], Sequence[bytes]]
"""Draws an evaluated design as PNG files: the robot, and frames of its motion."""

_LONGEST_ECHO = 12_000
"""Characters of an invalid reply that are sent back with its errors."""
_LONGEST_QUOTE = 80
"""Characters of an answer that are shown to the user."""
_MOST_ALIKE = 2
"""Answers for one slot with a trouble that lasts. After that, repeating is no use."""
_MOST_USELESS = 4
"""Answers with a trouble, after which a run stops that has not had a single one without."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class LLMSettings:
    """How a language model is used as a designer.

    Attributes:
        diversity: whether each proposal is shown all earlier ones (Diversity Reflection). Without
            it, proposals are independent samples and may repeat each other.
        repairs: how often an invalid reply is sent back with its errors before the proposal fails.
        history: how much of the history a prompt for an improvement holds.
        sampling: sampling settings of the model.
    """

    diversity: bool = True
    repairs: int = 3
    history: HistorySettings = field(default_factory=HistorySettings)
    sampling: Sampling = field(default_factory=Sampling)

    def __post_init__(self) -> None:
        """Raise `InputError` for a negative number of repairs."""
        if self.repairs < 0:
            raise InputError(f"repairs = {self.repairs} is less than 0")


@dataclass(slots=True)
class _Answers:
    """What came of the answers so far, over all remarks.

    Attributes:
        useful: whether the model can answer, although perhaps not yet in the right form.
        useless: answers without a design in conversations that ended without one. Those still under
            way are left out: how many there are side by side must not decide anything.
    """

    useful: bool = False
    useless: int = 0


class LLMDesigner:
    """Proposes with a language model (see `Designer`). Several threads may use it at once.

    A reply is looked up in the log before it is paid for. Its validation errors are logged too, so
    a resumed run takes the same way.
    """

    name = "llm"

    def __init__(
        self,
        task: Task,
        client: BudgetedClient,
        settings: LLMSettings | None = None,
        *,
        objective: str = "efficiency",
        check: RewardCheck = check_reward,
        dry_run: RewardCheck | None = None,
        pictures: Pictures | None = None,
        training: TrainingFacts | None = None,
        curve_of: CurveOf = lambda key: None,
    ) -> None:
        """Make a designer for one task.

        Args:
            task: the task to design for.
            client: the model with its log and its budget.
            settings: how the model is used.
            objective: what the search compares, `efficiency` or `fitness`.
            check: checks the program text of a reward.
            dry_run: runs a reward on moving robots for a short time, or `None` for no dry run.
            pictures: draws the design to improve on, for a model that can see.
            training: what trains, for the prompts.
            curve_of: returns the learning curve of an evaluation by its key. It has to return the
                same after an interruption, because prompts hold it.
        """
        self._task = task
        self._client = client
        self._settings = settings or LLMSettings()
        self.reflects = self._settings.diversity
        self.provenance = f"Proposed by a language model: {client.model.name}."
        self._objective = objective
        self._check = check
        self._dry_run = dry_run
        self._pictures = pictures
        self._training = training
        self._curve_of = curve_of
        # Only requests run in parallel. Up to Python 3.12, `ast.parse` can fail when two threads
        # parse at once (cpython#106905), and parallel dry runs would slow each other down.
        self._lock = threading.Lock()
        self._schema = morphology_schema(task)
        self._answers = _Answers()
        self._hint = ""

    def with_hint(self, hint: str) -> LLMDesigner:
        """Return the same designer with a person's remark in its prompts."""
        told = copy(self)
        told._hint = hint
        return told

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a morphology unlike all `earlier` ones (paper, Alg. 1: ProposeMorphology)."""
        shown = earlier if self.reflects else ()
        return self._morphology(slot, self._prompt("morphology", earlier=shown), shown)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return a reward unlike all `earlier` ones (paper, Alg. 1: ProposeReward)."""
        shown = earlier if self.reflects else ()
        return self._reward(slot, self._prompt("reward", earlier=shown), shown)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return a morphology to try with `best`'s reward (paper, Alg. 1: ImproveMorphology)."""
        source = best.design.reward.source
        tried = [e.design.morphology for e in (best, *history) if e.design.reward.source == source]
        return self._morphology(slot, self._improvement("morphology", best, history), tried)

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return a reward to try with `best`'s morphology (paper, Alg. 1: ImproveReward)."""
        parameters = best.design.morphology.parameters
        tried = [
            e.design.reward
            for e in (best, *history)
            if e.design.morphology.parameters == parameters
        ]
        return self._reward(slot, self._improvement("reward", best, history), tried)

    def _improvement(
        self, part: str, best: Evaluation, history: Sequence[Evaluation]
    ) -> list[Message]:
        role, question = self._prompt(
            f"improve-{part}", best=best, measured=history, settings=self._settings.history
        )
        with self._lock:
            images = tuple(self._pictures(best)) if self._pictures else ()
        if not images:
            return [role, question]
        return [role, Message("user", f"{question.text}\n\n{render('pictures')}", images)]

    def _prompt(self, kind: str, **given: Any) -> list[Message]:
        with self._lock:
            return render_prompt(
                self._task,
                kind,
                objective=self._objective,
                training=self._training,
                curve_of=self._curve_of,
                hint=self._hint,
                **given,
            )

    def _morphology(
        self, slot: Slot, prompt: Sequence[Message], taken: Sequence[Morphology]
    ) -> Morphology:
        def parse(exchange: Exchange) -> Morphology:
            return parse_morphology(exchange.reply, self._task, taken, exchange.truncated)

        return self._ask(slot, prompt, parse, self._schema)

    def _reward(self, slot: Slot, prompt: Sequence[Message], taken: Sequence[Reward]) -> Reward:
        def parse(exchange: Exchange) -> Reward:
            reward = parse_reward(exchange.reply, taken, exchange.truncated, self._check)
            # A dry run measures time, so it could give another result tomorrow. Its first result
            # is logged and holds.
            if exchange.validation_errors is None and self._dry_run is not None:
                found = self._dry_run(reward.source)
                # A warning is sent back once. After that, the model's choice is accepted.
                may_warn = not exchange.repair and self._settings.repairs
                warned = any(finding.severity == "warning" for finding in found)
                if error_messages(found) or (warned and may_warn):
                    raise InvalidReply(messages(found))
            return reward

        return self._ask(slot, prompt, parse, None)

    def _ask(
        self,
        slot: Slot,
        prompt: Sequence[Message],
        parse: Callable[[Exchange], T],
        schema: dict[str, Any] | None,
    ) -> T:
        """Ask until a reply is valid, and send its errors back each time.

        Raises:
            ProposalFailed: the repairs are used up, or repeating cannot help.
            ModelUnavailable: none of the answers so far held a design.
        """
        *before, question = prompt
        if slot.attempt:
            # Some models give the same answer to the same words.
            fresh = render("fresh", attempt=str(slot.attempt + 1))
            question = replace(question, text=f"{question.text}\n\n{fresh}")
        conversation = (*before, question)
        alike = useless = 0
        for repair in range(self._settings.repairs + 1):
            request = Request(slot, repair, conversation, schema, self._settings.sampling)
            exchange = self._client.ask(request)
            trouble = trouble_with(exchange)
            alike = alike + 1 if trouble and trouble.lasting else 0
            try:
                if exchange.validation_errors:
                    raise InvalidReply(exchange.validation_errors)
                with self._lock:
                    proposal = parse(exchange)
            except InvalidReply as invalid:
                trouble = trouble or _without_design(exchange.reply, slot.kind, self._task)
                errors = _explained(invalid.errors, trouble)
                self._client.set_errors(exchange, errors)
            else:
                self._answers.useful = True
                self._client.set_errors(exchange, ())
                return proposal
            said = [trouble.to_user] if trouble else list(errors)
            if cut := prompt_cut(exchange.messages, exchange.input_tokens):
                said.append(cut)
            useless += bool(trouble)
            if not trouble:
                self._answers.useful = True
            self._stop_if_useless(useless, said)
            if alike == _MOST_ALIKE:
                break
            # Some providers refuse an empty message.
            echo = exchange.reply[:_LONGEST_ECHO] or "(no answer)"
            conversation = (*conversation, Message("assistant", echo), repair_message(errors))
        self._answers.useless += useless
        raise ProposalFailed(
            f"no usable {slot.kind} in {repair + 1} answers; wrong with the last: "
            + "; ".join(said)
        )

    def _stop_if_useless(self, here: int, said: Sequence[str]) -> None:
        """Raise `ModelUnavailable` if no answer held a design so far, nor `here` ones now."""
        count = self._answers.useless + here
        if count >= _MOST_USELESS and not self._answers.useful:
            raise ModelUnavailable(
                f"{self._client.model.name} gave {count} answers and none holds a whole design: "
                f"{'; '.join(said)}. Start a new run (--out) with other settings"
            )


def _without_design(reply: str, kind: str, task: Task) -> Trouble | None:
    """Return the trouble with a whole answer that holds no design, `None` if it holds one."""
    why = unreadable(reply, kind, task)
    if not why:
        return None
    lines = [line for line in map(one_line, reply.splitlines()) if line]
    first = lines[0] if lines else ""
    quote = first if len(first) <= _LONGEST_QUOTE else first[:_LONGEST_QUOTE] + "…"
    return Trouble(
        f"{why}; it begins {quote!r}; choose another model, or see with `robomore llm check` "
        "whether this one can answer in JSON",
        why,
        lasting=False,
    )


def _explained(errors: Sequence[str], trouble: Trouble | None) -> tuple[str, ...]:
    """Return the errors of a reply with the true reason first."""
    if trouble is None:
        return tuple(errors)
    others = [e for e in errors if e not in (trouble.to_model, EMPTY)]
    if trouble.lasting:
        # Nothing else about such an answer is worth a correction.
        return (trouble.to_model,)
    return (trouble.to_model, *others)
