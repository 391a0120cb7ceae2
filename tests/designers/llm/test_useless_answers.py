"""Answers without content: the true reason is told, and what cannot help is not repeated."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest
from test_llm_designer import BODY, REWARD, coded, designer, said

from llm.scripted import ScriptedModel
from robomore.designers.llm.designer import LLMSettings
from robomore.errors import ModelUnavailable, ProposalFailed
from robomore.llm import Completion, MemoryLog, ReplayModel, Request
from robomore.types import Slot

OUT_OF_TOKENS = Completion("", truncated=True, output_tokens=2048)
FILTERED = Completion("", ending="filter")
REFUSED = Completion("I cannot help with weapons.", ending="refusal")
THOUGHTS = Completion(f"{said(0.3)} or {said(0.4)}?", ending="thoughts")
CUT_OFF = Completion('{"parameters": {"fro', truncated=True, output_tokens=4096)
LASTING = pytest.mark.parametrize(
    ("answer", "to_user", "to_model"),
    [
        (OUT_OF_TOKENS, "raise --max-output-tokens, or let it think less", "think less"),
        (FILTERED, "content filter withheld the answer; choose another model", "content filter"),
        (REFUSED, "refused to answer \\('I cannot help with weapons.'\\)", "simulated robot"),
    ],
)


@LASTING
def test_a_slot_is_given_up_early_for_a_reason_that_lasts(
    answer: Completion, to_user: str, to_model: str
) -> None:
    model, log = ScriptedModel(lambda asked: answer), MemoryLog()
    with pytest.raises(ProposalFailed, match=f"no usable reward in 2 answers.*{to_user}"):
        designer(model, log).propose_reward(REWARD, [])
    assert len(model.asked) == 2
    repair = model.asked[1].messages[-1].text
    assert to_model in repair and "--" not in repair and "answer more briefly" not in repair
    assert all(to_model in exchange.validation_errors[0] for exchange in log.all())


@LASTING
def test_a_run_that_had_no_useful_answer_stops(
    answer: Completion, to_user: str, to_model: str
) -> None:
    log = MemoryLog()
    made = designer(ScriptedModel(lambda asked: answer), log)
    with pytest.raises(ProposalFailed):
        made.propose_morphology(BODY, [])
    with pytest.raises(ModelUnavailable, match=f"4 answers and none holds .*{to_user}.*--out"):
        made.propose_morphology(Slot("coarse", "morphology", (0,), attempt=1), [])
    # The same command takes the same way, and pays for nothing.
    again = designer(ReplayModel(log), MemoryLog())
    with pytest.raises(ProposalFailed):
        again.propose_morphology(BODY, [])
    with pytest.raises(ModelUnavailable):
        again.propose_morphology(Slot("coarse", "morphology", (0,), attempt=1), [])


def test_a_run_with_a_useful_answer_goes_on() -> None:
    answers = [said(0.3), *[FILTERED] * 6, coded(1)]
    made = designer(answers)
    made.propose_morphology(BODY, [])
    for attempt in range(3):
        with pytest.raises(ProposalFailed):
            made.propose_reward(Slot("coarse", "reward", (0,), attempt=attempt), [])
    assert made.propose_reward(Slot("coarse", "reward", (1,)), [])


NESTED = '{"parameters":' * 20_000
BROKEN = '{"parameters": {"front_length" 0.3}}'


@pytest.mark.parametrize(
    "answer", ["I'm sorry, I can't.", "<think>hm</think>", "[1, 2]", NESTED, BROKEN]
)
def test_answers_without_a_design_are_counted_over_slots(answer: str) -> None:
    model = ScriptedModel(lambda asked: answer)
    made = designer(model, settings=LLMSettings(repairs=1))
    with pytest.raises(ProposalFailed, match="choose another model"):
        made.propose_morphology(BODY, [])
    with pytest.raises(ModelUnavailable, match=r"4 answers and none holds .*it begins"):
        made.propose_reward(REWARD, [])
    assert len(model.asked) == 4


def test_a_model_that_answers_with_a_design_at_last_goes_on() -> None:
    refusal = "I'm sorry, I can't."
    made = designer([*[refusal] * 3, said(0.3), *[refusal] * 4, said(0.4)])
    assert made.propose_morphology(BODY, []).parameters[0] == 0.3
    again = Slot("coarse", "morphology", (1,))
    with pytest.raises(ProposalFailed, match=r"it begins .I.m sorry, I can.t"):
        made.propose_morphology(again, [])
    assert made.propose_morphology(Slot("coarse", "morphology", (1,), attempt=1), [])


def test_thinking_that_ends_in_time_at_the_second_try_is_no_failure() -> None:
    assert designer([OUT_OF_TOKENS, said(0.3)]).propose_morphology(BODY, [])


def test_an_answer_within_thoughts_is_read_or_told_so() -> None:
    inside = Completion(f"So: {said(0.3)}", ending="thoughts")
    assert designer([inside]).propose_morphology(BODY, []).parameters[0] == 0.3
    model = ScriptedModel([THOUGHTS, said(0.3)])
    assert designer(model).propose_morphology(BODY, [])
    repair = model.asked[1].messages[-1].text
    assert "holds thoughts alone" in repair and "2 different designs" in repair


def test_a_user_is_told_the_remedy_for_answers_that_are_cut_off() -> None:
    made = designer(ScriptedModel(lambda asked: CUT_OFF), settings=LLMSettings(repairs=1))
    with pytest.raises(ProposalFailed, match=r"cut off .*4,096 output tokens.*--max-output-tokens"):
        made.propose_morphology(BODY, [])


def test_a_user_is_told_that_the_server_cut_the_prompt() -> None:
    answer = Completion("What do you mean?", input_tokens=450)
    made = designer(ScriptedModel(lambda asked: answer), settings=LLMSettings(repairs=0))
    with pytest.raises(ProposalFailed, match=r"no JSON object.*read 450 tokens.*OLLAMA_CONTEXT"):
        made.propose_morphology(BODY, [])


def test_useless_first_answers_side_by_side_stop_nothing() -> None:
    count = 8
    together = Barrier(count, timeout=10.0)

    def answer(asked: Request) -> str:
        together.wait()  # all first answers were useless before anybody has a better one
        return coded(1 + asked.slot.index[0]) if asked.repair else "wait"

    made = designer(ScriptedModel(answer))
    slots = [Slot("coarse", "reward", (index,)) for index in range(count)]
    with ThreadPoolExecutor(count) as pool:
        found = list(pool.map(lambda slot: made.propose_reward(slot, []), slots))
    assert len({one.source for one in found}) == count
