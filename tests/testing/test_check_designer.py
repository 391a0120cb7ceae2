"""The contract check passes our designers, and finds each fault."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

sys.path.append(str(Path(__file__).parents[2] / "examples" / "eel"))
from eel import EEL

from llm.scripted import ScriptedModel
from robomore.designers.llm.designer import LLMDesigner
from robomore.designers.offline.designer import OfflineDesigner
from robomore.errors import ProposalFailed
from robomore.llm import BudgetedClient, MemoryLog, Request
from robomore.tasks import Task, get_task
from robomore.testing.designers import check_designer
from robomore.types import Morphology, Reward, Slot

SWIMMER = get_task("swimmer")


@pytest.mark.parametrize(
    "task",
    [
        SWIMMER,
        pytest.param(EEL, marks=pytest.mark.exhaustive),
        pytest.param(get_task("ant-jump"), marks=pytest.mark.exhaustive),
    ],
    ids=lambda task: task.id,
)
def test_the_offline_designer_keeps_the_contract(task: Task) -> None:
    check_designer(OfflineDesigner, task)


def answer(asked: Request) -> str:
    """Return a wrong answer first, and then one that depends on the slot alone."""
    if asked.repair == 0:
        return "Let me think about it."
    number = 1 + asked.slot.index[-1] + 10 * asked.slot.improves + 5 * asked.slot.attempt
    if asked.slot.kind == "reward":
        return (
            "def _get_rew(self, x_velocity, action):\n"
            f"    return {number} * x_velocity, {{'speed': {number} * x_velocity}}\n"
        )
    values = [p.low + (0.5 + 0.005 * number) * (p.high - p.low) for p in SWIMMER.parameters]
    return json.dumps({"parameters": values, "description": f"number {number}"})


def test_the_llm_designer_keeps_the_contract() -> None:
    def make(task: Task, seed: int, objective: str) -> LLMDesigner:
        client = BudgetedClient(ScriptedModel(answer), MemoryLog())
        return LLMDesigner(task, client, objective=objective)

    check_designer(make, SWIMMER)


class Plain:
    """A designer that keeps the contract by always proposing the reference."""

    name, provenance, reflects = "plain", "No LLM was used: the reference.", False

    def __init__(self, task: Task, seed: int, objective: str) -> None:
        self.morphology = Morphology(task.reference)
        self.reward = Reward(task.reward)
        self.calls = 0

    def propose_morphology(self, slot: Slot, *others: Any) -> Any:
        self.calls += 1
        return self.changed(self.morphology, slot, *others)

    def propose_reward(self, slot: Slot, *others: Any) -> Any:
        self.calls += 1
        return self.changed(self.reward, slot, *others)

    improve_morphology, improve_reward = propose_morphology, propose_reward

    def changed(self, proposal: Any, slot: Slot, *others: Any) -> Any:
        return proposal


def test_a_plain_designer_keeps_the_contract() -> None:
    check_designer(Plain, SWIMMER)


def changing(change: Callable[..., Any]) -> type[Plain]:
    return type("Changed", (Plain,), {"changed": change})


def raising(self: Any, proposal: Any, slot: Slot, *others: Any) -> Any:
    raise ValueError("oops")


def failing(self: Any, proposal: Any, slot: Slot, *others: Any) -> Any:
    raise ProposalFailed("never")


def failing_on_failures(self: Any, proposal: Any, slot: Slot, *others: Any) -> Any:
    if slot.improves and not all(e.ok for e in others[1]):
        raise KeyError("fitness")
    return proposal


@pytest.mark.parametrize(
    ("designer", "said"),
    [
        (type("Nameless", (Plain,), {"name": ""}), "`name` has to be a text"),
        (type("Silent", (Plain,), {"provenance": None}), "`provenance` has to be a text"),
        (type("Blind", (Plain,), {"reflects": None}), "`reflects` has to say"),
        (changing(lambda self, proposal, *_: None), "returned no Morphology: None"),
        (changing(lambda self, *_: Morphology((9.0,) * 6)), "returned an invalid morphology"),
        (changing(lambda self, *_: Morphology((0.1,))), "returned an invalid morphology"),
        (
            changing(lambda self, one, *_: one if hasattr(one, "parameters") else Reward("def")),
            "returned a reward that cannot be used",
        ),
        (changing(raising), "raised ValueError"),
        (changing(failing), "raised ProposalFailed in every slot"),
        (changing(failing_on_failures), "raised KeyError"),
        (
            changing(lambda self, one, *_: type(one)(*vars_of(one), idea=f"{self.calls}")),
            "calls come in another order",
        ),
    ],
)
def test_each_fault_is_found(designer: type[Plain], said: str) -> None:
    with pytest.raises(AssertionError, match=said):
        check_designer(designer, SWIMMER)


def test_an_answer_that_changes_from_call_to_call_is_found() -> None:
    asked: set[Any] = set()

    def forgetful(self: Any, one: Any, slot: Slot, *others: Any) -> Any:
        key = (id(self), slot, len(others[-1]))
        repeated = key in asked
        asked.add(key)
        return type(one)(*vars_of(one), idea="again" if repeated else "first")

    with pytest.raises(AssertionError, match="the same arguments the second time"):
        check_designer(changing(forgetful), SWIMMER)


def vars_of(proposal: Morphology | Reward) -> tuple[Any]:
    """Return the proposal without its idea."""
    return (proposal.parameters if isinstance(proposal, Morphology) else proposal.source,)
