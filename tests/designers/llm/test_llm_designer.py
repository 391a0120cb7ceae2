"""The whole designer against a scripted model: proposals, repairs, budgets, crashes, replay."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import Barrier, Lock
from time import sleep

import pytest
from measured import SWIMMER, body, evaluation, grid, reward

from llm.loopback import serve
from llm.scripted import DyingLog, Killed, ScriptedModel
from robomore.designers.designer import Designer
from robomore.designers.llm.designer import LLMDesigner, LLMSettings
from robomore.designers.llm.history import HistorySettings
from robomore.errors import BudgetExhausted, InputError, ProposalFailed
from robomore.executors import thread_map
from robomore.llm import BudgetedClient, MemoryLog, ModelBudget, ReplayModel, Request, Sampling
from robomore.rewards.check import Finding
from robomore.types import Slot

BODY = Slot("coarse", "morphology", (0,))
REWARD = Slot("coarse", "reward", (0,))
BETTER_BODY = Slot("fine", "morphology", (1, 1), improves=True)
BETTER_REWARD = Slot("fine", "reward", (1, 1), improves=True)


def said(*values: float, idea: str = "a new idea") -> str:
    return json.dumps({"parameters": body(*values).parameters, "description": idea})


def coded(weight: float) -> str:
    return f"```python\n{reward(weight).source}```"


def designer(
    model: ScriptedModel | Sequence[str], log: MemoryLog | None = None, **given
) -> LLMDesigner:
    if not hasattr(model, "complete"):
        model = ScriptedModel(model)
    budget = given.pop("budget", None)
    settings = given.pop("settings", LLMSettings())
    log = MemoryLog() if log is None else log
    return LLMDesigner(SWIMMER, BudgetedClient(model, log, budget), settings, **given)


def test_it_is_a_designer_and_says_who_designs() -> None:
    made: Designer = designer(ScriptedModel([], name="openai:some-model"))
    assert made.name == "llm"
    assert made.provenance == "Proposed by a language model: openai:some-model."


def test_proposals_see_all_earlier_ones() -> None:
    model = ScriptedModel([said(0.3, idea="first"), said(0.4, idea="second"), coded(1), coded(2)])
    made = designer(model)
    first = made.propose_morphology(BODY, [])
    second = made.propose_morphology(Slot("coarse", "morphology", (1,)), [first])
    assert (first.idea, second.idea) == ("first", "second")
    assert "Idea: first" not in model.asked[0].messages[1].text
    assert "Idea: first" in model.asked[1].messages[1].text
    assert model.asked[0].schema["title"] == "morphology"
    one = made.propose_reward(REWARD, [])
    two = made.propose_reward(Slot("coarse", "reward", (1,)), [one])
    assert (one.source, two.idea) == (reward(1).source, "Speed, 2 times.")
    assert one.source.strip() in model.asked[3].messages[1].text
    assert model.asked[3].schema is None


def test_without_diversity_reflection_proposals_are_independent() -> None:
    model = ScriptedModel([said(0.3), said(0.3), coded(1), coded(1)])
    made = designer(model, settings=LLMSettings(diversity=False))
    first = made.propose_morphology(BODY, [])
    again = made.propose_morphology(Slot("coarse", "morphology", (1,)), [first])
    assert first == again
    one = made.propose_reward(REWARD, [])
    assert made.propose_reward(Slot("coarse", "reward", (1,)), [one]) == one
    prompts = [asked.messages for asked in model.asked]
    assert prompts[0] == prompts[1] and prompts[2] == prompts[3]


def test_a_bad_reply_is_told_its_exact_fault_and_repaired() -> None:
    model = ScriptedModel(["no idea", said(99), said(0.3)])
    log = MemoryLog()
    assert designer(model, log).propose_morphology(BODY, []).parameters[0] == 0.3
    last = model.asked[2].messages
    assert [message.role for message in last] == [
        *("system", "user", "assistant", "user", "assistant", "user"),
    ]
    assert last[2].text == "no idea" and "no JSON object" in last[3].text
    assert "front_length = 99 m is outside [0.05, 3]" in last[5].text
    assert [exchange.repair for exchange in log.all()] == [0, 1, 2]
    errors = [exchange.validation_errors for exchange in log.all()]
    assert "no JSON object" in errors[0][0] and "outside" in errors[1][0]
    assert errors[2] == ()


@pytest.mark.parametrize("repairs", [0, 1, 3])
def test_repairs_are_bounded_and_the_slot_fails(repairs: int) -> None:
    model = ScriptedModel(lambda asked: "def _get_rew(self): ...")
    made = designer(model, settings=LLMSettings(repairs=repairs))
    with pytest.raises(ProposalFailed, match=rf"no usable reward in {repairs + 1} answers"):
        made.propose_reward(REWARD, [])
    assert len(model.asked) == repairs + 1


def test_a_fresh_attempt_is_a_new_exchange() -> None:
    model = ScriptedModel(["no", said(0.3)])
    made = designer(model, settings=LLMSettings(repairs=0))
    with pytest.raises(ProposalFailed):
        made.propose_morphology(BODY, [])
    assert made.propose_morphology(Slot("coarse", "morphology", (0,), attempt=1), [])
    # A model that is not left to chance would say the same again to the same words.
    first, second = (asked.messages for asked in model.asked)
    assert second[0] == first[0]
    assert second[1].text.startswith(first[1].text) and "attempt 2" in second[1].text


def test_what_was_tried_is_not_proposed_again() -> None:
    best = evaluation(body(0.3), reward(1), 5.0)
    other = evaluation(body(0.4), reward(2), 4.0)
    model = ScriptedModel([said(0.3), said(0.4), coded(1), coded(2)])
    made = designer(model)
    # Body 0.4 was tried with another reward only, so it may be tried with this one.
    assert made.improve_morphology(BETTER_BODY, best, [best, other]).parameters[0] == 0.4
    assert "same morphology as number 1" in model.asked[1].messages[-1].text
    assert made.improve_reward(BETTER_REWARD, best, [best, other]).source == reward(2).source
    assert "same reward as number 1" in model.asked[3].messages[-1].text


def test_the_history_is_cut_to_its_budget() -> None:
    measured = grid([body(0.1 + i / 50) for i in range(25)], [reward(1 + j) for j in range(5)])
    lengths = []
    for tokens in (500, 4000):
        model = ScriptedModel([said(2.5)])
        settings = LLMSettings(history=HistorySettings(tokens))
        designer(model, settings=settings).improve_morphology(BETTER_BODY, measured[-1], measured)
        lengths.append(model.asked[0].messages[1].text.count("## Morphology"))
    assert 0 < lengths[0] < lengths[1] <= 25


def test_settings_reach_the_model_and_the_log() -> None:
    model, log = ScriptedModel([said(0.3)]), MemoryLog()
    sampling = Sampling(temperature=0.9, max_output_tokens=500)
    designer(model, log, settings=LLMSettings(sampling=sampling)).propose_morphology(BODY, [])
    assert model.asked[0].sampling == sampling == log.all()[0].sampling


def test_nonsense_settings_are_refused() -> None:
    for make in (
        lambda: LLMSettings(repairs=-1),
        lambda: HistorySettings(-1),
        lambda: HistorySettings(10, "luck"),
    ):
        with pytest.raises(InputError):
            make()


def test_a_dry_run_happens_once() -> None:
    calls = []

    def dry_run(source: str) -> list[Finding]:
        calls.append(source)
        bad = "1 * x" in source
        return [Finding(4, "error", "the reward never changes")] * bad + [
            Finding(4, "warning", "one term dominates")
        ]

    model, log = ScriptedModel([coded(1), coded(2)]), MemoryLog()
    made = designer(model, log, dry_run=dry_run)
    assert made.propose_reward(REWARD, []).source == reward(2).source
    assert "line 4: the reward never changes" in model.asked[1].messages[-1].text
    assert len(calls) == 2
    # A resumed run keeps the first result, whatever a second dry run would give.
    again = designer(model, log, dry_run=lambda source: [Finding(1, "error", "slow today")])
    assert again.propose_reward(REWARD, []).source == reward(2).source
    assert len(model.asked) == 2


def test_a_warning_is_sent_back_once_and_then_the_choice_is_accepted() -> None:
    log, tried = MemoryLog(), []

    def dry_run(source: str) -> list[Finding]:
        tried.append(source)
        return [Finding(1, "warning", "one term dominates")]

    made = designer([coded(1), coded(1)], log, dry_run=dry_run, settings=LLMSettings(repairs=1))
    assert made.propose_reward(REWARD, []).source == reward(1).source
    assert len(tried) == 2
    errors = [exchange.validation_errors for exchange in log.all()]
    assert errors == [("line 1: one term dominates",), ()]


def test_pictures_go_into_improvements_alone() -> None:
    model = ScriptedModel([said(0.3), said(0.4)])
    made = designer(model, pictures=lambda best: [b"png of the body", b"png of the motion"])
    made.propose_morphology(BODY, [])
    best = evaluation(body(0.5), reward(1), 5.0)
    made.improve_morphology(BETTER_BODY, best, [best])
    assert model.asked[0].messages[1].images == ()
    assert model.asked[1].messages[1].images == (b"png of the body", b"png of the motion")
    assert "The pictures show the best so far" in model.asked[1].messages[1].text


def test_a_monstrous_reply_is_not_echoed_in_full() -> None:
    model = ScriptedModel(["blah " * 100_000, said(0.3)])
    designer(model).propose_morphology(BODY, [])
    assert len(model.asked[1].messages[2].text) <= 12_000


def test_an_empty_reply_is_answered_too() -> None:
    model = ScriptedModel(["", said(0.3)])
    designer(model).propose_morphology(BODY, [])
    assert model.asked[1].messages[2].text
    assert "the answer is empty" in model.asked[1].messages[3].text


def whole_run(made: Designer) -> list[object]:
    """A small search, one slot after the other."""
    bodies = []
    for i in range(2):
        bodies.append(made.propose_morphology(Slot("coarse", "morphology", (i,)), bodies))
    programs = []
    for j in range(2):
        programs.append(made.propose_reward(Slot("coarse", "reward", (j,)), programs))
    measured = grid(bodies, programs)
    better = made.improve_morphology(BETTER_BODY, measured[-1], measured)
    measured.append(evaluation(better, programs[-1], 50.0))
    return [*bodies, *programs, better, made.improve_reward(BETTER_REWARD, measured[-1], measured)]


def clumsy(asked: Request) -> str:
    """A model that gets every first answer wrong, and depends on nothing but the request."""
    if asked.repair == 0:
        return "Let me think about it."
    number = 10 * asked.slot.improves + asked.slot.index[-1] + 1
    return said(number / 20) if asked.slot.kind == "morphology" else coded(number)


EXCHANGES = 12
"""Exchanges of `whole_run` with `clumsy`."""


@pytest.mark.parametrize("call", ["add", "set_errors"])
@pytest.mark.parametrize(
    "number",
    [
        n if n in (1, 6, EXCHANGES) else pytest.param(n, marks=pytest.mark.exhaustive)
        for n in range(1, EXCHANGES + 1)
    ],
)
def test_a_run_killed_anywhere_loses_nothing_and_pays_nothing_twice(number: int, call: str) -> None:
    log = MemoryLog()
    expected = whole_run(designer(ScriptedModel(clumsy), log))
    for after in (False, True):
        model = ScriptedModel(clumsy)
        dying = DyingLog([], call, number, after)
        with pytest.raises(Killed):
            whole_run(designer(model, dying))
        resumed = MemoryLog(dying.all())
        assert whole_run(designer(model, resumed)) == expected
        # Only an answer that was never logged is asked for again.
        lost = call == "add" and not after
        assert len(model.asked) == EXCHANGES + lost
        assert resumed.all() == log.all()


def test_a_budget_stops_a_run_and_more_of_it_finishes_it() -> None:
    model, log = ScriptedModel(clumsy), MemoryLog()
    expected = whole_run(designer(ScriptedModel(clumsy)))
    with pytest.raises(BudgetExhausted):
        whole_run(designer(model, log, budget=ModelBudget(requests=5)))
    assert len(model.asked) == 5
    assert whole_run(designer(model, log, budget=ModelBudget(requests=12))) == expected
    assert len(model.asked) == 12


def test_a_replay_gives_the_same_run_without_a_model() -> None:
    log, own = MemoryLog(), MemoryLog()
    recorded = whole_run(designer(ScriptedModel(clumsy), log))
    replayed = whole_run(designer(ReplayModel(log), own))
    assert replayed == recorded
    assert own.spent().requests == 0
    assert [e.key for e in own.all()] == [e.key for e in log.all()]


def test_a_replay_with_other_settings_says_so() -> None:
    log = MemoryLog()
    whole_run(designer(ScriptedModel(clumsy), log))
    other = designer(ReplayModel(log), settings=LLMSettings(diversity=False))
    with pytest.raises(InputError, match="another prompt for coarse morphology 2"):
        whole_run(other)


def test_a_replay_by_slot_reuses_proposals_under_other_numbers() -> None:
    log = MemoryLog()
    recorded = whole_run(designer(ScriptedModel(clumsy), log))
    replay = designer(ReplayModel(log, by="slot"))
    measured = [evaluation(body(0.9), reward(9), 123.0)]
    assert replay.improve_morphology(BETTER_BODY, measured[0], measured) == recorded[4]


def test_branches_side_by_side_give_what_they_give_in_turn() -> None:
    best = evaluation(body(0.9), reward(9), 9.0)
    slots = [Slot("fine", "reward", (branch, 1), improves=True) for branch in range(8)]

    def weight(asked: Request) -> str:
        return coded(asked.slot.index[0] + 1) if asked.repair else "wait"

    def run(workers: int) -> tuple[list[object], list[str]]:
        log = MemoryLog()
        made = designer(ScriptedModel(weight), log)
        with ThreadPoolExecutor(workers) as pool:
            found = list(pool.map(lambda slot: made.improve_reward(slot, best, [best]), slots))
        return found, sorted(exchange.key for exchange in log.all())

    assert run(1) == run(8)


def test_ideas_cannot_move_the_cursor() -> None:
    made = designer([said(0.3, idea="\x1b[2Jcalm\n\u202eidea")])
    assert re.fullmatch(r"[\w\[ ]+", made.propose_morphology(BODY, []).idea)


def test_over_a_real_connection_that_misbehaves() -> None:
    pytest.importorskip("pydantic_ai")
    from robomore.llm import connect
    from robomore.llm.retry import RetryPolicy

    steps = ["busy", "drop", "no_schema", ("say", said(0.3)), "half", "cut_off", ("say", coded(1))]
    log = MemoryLog()
    with serve(*steps) as (url, script):
        model = connect("toy", base_url=url, retry_policy=RetryPolicy(initial_wait=0.01))
        model._sleep = lambda seconds: None
        made = LLMDesigner(SWIMMER, BudgetedClient(model, log))
        assert made.propose_morphology(BODY, []).parameters[0] == 0.3
        assert made.propose_reward(REWARD, []).source == reward(1).source
        # Resumed: everything is known, nothing is sent.
        sent = len(script.seen)
        again = LLMDesigner(SWIMMER, BudgetedClient(model, log))
        again.propose_morphology(BODY, [])
        again.propose_reward(REWARD, [])
    assert sent == len(script.seen) == len(steps)
    assert [exchange.tries for exchange in log.all()] == [4, 2, 1]


def test_a_budget_of_requests_counts_each_try_and_is_never_passed() -> None:
    pytest.importorskip("pydantic_ai")
    from robomore.llm import connect
    from robomore.llm.retry import RetryPolicy

    log = MemoryLog()
    with serve("broken", "half", "broken", ("say", said(0.3)), ("say", coded(1))) as (url, script):
        model = connect("toy", base_url=url, retry_policy=RetryPolicy(initial_wait=0.01))
        model._sleep = lambda seconds: None
        for allowed, sent in ((2, 2), (2, 2), (3, 3)):
            made = designer(model, log, budget=ModelBudget(requests=allowed))
            with pytest.raises(BudgetExhausted, match="--max-requests"):
                made.propose_morphology(BODY, [])
            assert len(script.seen) == log.spent().requests == sent
        made = designer(model, log, budget=ModelBudget(requests=5))
        assert made.propose_morphology(BODY, []).parameters[0] == 0.3
        assert made.propose_reward(REWARD, []).source == reward(1).source
    assert len(script.seen) == log.spent().requests == 5


def test_side_by_side_a_spent_budget_costs_nothing_but_the_wait() -> None:
    """Which branch is refused depends on timing; what comes out in the end does not."""
    best = evaluation(body(0.9), reward(9), 9.0)
    slots = [Slot("fine", "reward", (branch, 1), improves=True) for branch in range(6)]

    def answer(asked: Request) -> str:
        return coded(asked.slot.index[0] + 1) if asked.repair else "wait"

    def ask(log: MemoryLog, limit: int | None) -> list[object]:
        made = designer(ScriptedModel(answer), log, budget=ModelBudget(requests=limit))
        return thread_map(3)([partial(made.improve_reward, slot, best, [best]) for slot in slots])

    expected, log = ask(MemoryLog(), None), MemoryLog()
    for limit in (1, 4, 7, 11):
        with pytest.raises(BudgetExhausted):
            ask(log, limit)
        assert log.spent().requests == limit
    assert ask(log, 12) == expected
    assert len(log.all()) == log.spent().requests == 12


def test_only_asking_goes_on_side_by_side() -> None:
    """Up to Python 3.12 two threads must not parse at once, and dry runs measure time."""
    best = evaluation(body(0.9), reward(9), 9.0)
    asking = Barrier(3, timeout=20)
    lock, under_way, most = Lock(), 0, 0

    def alone(source: str) -> list[Finding]:
        nonlocal under_way, most
        with lock:
            under_way += 1
            most = max(most, under_way)
        sleep(0.01)
        with lock:
            under_way -= 1
        return []

    def answer(asked: Request) -> str:
        asking.wait()
        return coded(asked.slot.index[0] + 1)

    made = designer(ScriptedModel(answer), check=alone, dry_run=alone)
    slots = [Slot("fine", "reward", (branch, 1), improves=True) for branch in range(6)]
    thread_map(3)([partial(made.improve_reward, slot, best, [best]) for slot in slots])
    assert most == 1
