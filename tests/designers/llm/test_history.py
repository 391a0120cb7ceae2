"""Which part of the history a prompt holds, and what it says about the choice."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from measured import SWIMMER, body, evaluation, grid, reward

from robomore.designers.llm.formatting import curve_line
from robomore.designers.llm.history import (
    RULES,
    Entry,
    HistorySettings,
    choose,
    morphology_entries,
    reward_entries,
    select,
)
from robomore.errors import InputError
from robomore.llm.tokens import estimate_tokens
from robomore.types import Curve, Evaluation, Status


def entry(score: float | None, place: float = 0.0, length: int = 40) -> Entry:
    return Entry("x" * length, score, (place,))


LINE = [entry(float(i), place=i / 10) for i in range(10)]
COST = estimate_tokens("x" * 40) + 2


def chosen(rule: str, count: int, entries: list[Entry] = LINE) -> list[int]:
    return choose(entries, HistorySettings(count * COST, rule))


def test_each_name_of_the_rule_takes_its_turn() -> None:
    assert chosen("best", 3) == [9, 8, 7]
    assert chosen("worst", 3) == [0, 1, 2]
    assert chosen("recent", 2) == [9, 8]
    assert chosen("best+worst", 4) == [9, 0, 8, 1]
    # The most different from the best is the worst; then the one in the middle.
    assert chosen("best+different+different", 3) == [9, 0, 4]


def test_failures_have_a_turn_of_their_own() -> None:
    entries = [entry(1.0), entry(None), entry(2.0), entry(None)]
    assert chosen("best+failed", 3, entries) == [2, 3, 0]
    assert chosen("failed", 4, entries) == [3, 1]
    assert chosen("best", 4, entries) == [2, 0]


def test_equal_ones_fall_to_the_oldest() -> None:
    assert chosen("best", 2, [entry(1.0), entry(1.0), entry(1.0)]) == [0, 1]


def test_a_long_entry_costs_only_itself() -> None:
    entries = [entry(3.0, length=5000), entry(2.0), entry(1.0)]
    assert chosen("best", 2, entries) == [1, 2]


@given(
    st.lists(
        st.tuples(st.one_of(st.none(), st.floats(-5, 5)), st.floats(0, 1), st.integers(1, 300)),
        max_size=12,
    ),
    st.integers(0, 400),
    st.lists(st.sampled_from(list(RULES)), min_size=1, max_size=4),
)
def test_the_budget_is_kept_whatever_the_rule(
    made: list[tuple[float | None, float, int]], tokens: int, rule: list[str]
) -> None:
    entries = [entry(*values) for values in made]
    settings = HistorySettings(tokens, "+".join(rule))
    taken = choose(entries, settings)
    assert len(set(taken)) == len(taken)
    assert sum(estimate_tokens(entries[i].text) for i in taken) <= tokens
    assert taken == choose(entries, settings)


def test_an_unknown_rule_is_named() -> None:
    with pytest.raises(InputError, match="'wurst' is none of best, worst"):
        choose(LINE, HistorySettings(rule="best+wurst"))


def test_a_morphology_is_one_entry_with_all_its_results() -> None:
    small, large = body(0.3, idea="small"), body(0.7)
    measured = grid([small, large], [reward(1), reward(2)])
    entries = morphology_entries(SWIMMER, "efficiency", reward(1), measured)
    assert len(entries) == 2
    assert entries[0].score == measured[1].efficiency
    text = entries[0].text
    assert text.startswith("## Morphology 1\nParameters: front_length 0.3")
    assert "Idea: small" in text
    assert f"With the current reward: efficiency {measured[0].efficiency:.4g}" in text
    # The other results stand in the table.
    assert text.count("efficiency") == 1


def test_a_design_that_was_proposed_twice_is_shown_once() -> None:
    one = evaluation(body(0.3), reward(1), 5.0)
    (entry,) = morphology_entries(SWIMMER, "efficiency", reward(1), [one, one])
    assert entry.text.count("With the current reward") == 1


def test_a_reward_is_one_entry_with_all_its_results() -> None:
    few = [body(0.1 + i / 10) for i in range(9)]
    measured = grid(few, [reward(1), reward(2)])
    entries = reward_entries(SWIMMER, "efficiency", few[3], measured)
    assert len(entries) == 2
    text = entries[1].text
    assert reward(2).source.strip() in text and text.startswith("## Reward 2")
    assert f"With the current morphology: efficiency {measured[7].efficiency:.4g}" in text
    assert text.count("efficiency") == 1


def test_an_entry_without_success_at_hand_describes_the_best_other_in_full() -> None:
    measured = [
        evaluation(body(0.3), reward(1), None),
        evaluation(body(0.5), reward(1), 1.0),
        evaluation(body(0.7), reward(1), 2.0),
    ]
    (entry,) = reward_entries(SWIMMER, "fitness", body(0.3), measured)
    assert "With the current morphology: failed (reward-failed): line 3" in entry.text
    assert "With morphology 3, its best: efficiency" in entry.text
    assert "(fitness 2 m" in entry.text.split("its best")[1]
    assert entry.text.count("How it moved") == 1


def cut(one: Evaluation, steps: int) -> Evaluation:
    return replace(one, job=replace(one.job, steps=steps))


def test_what_was_cut_short_says_so_and_stands_below_the_rest() -> None:
    measured = [
        cut(evaluation(body(0.3), reward(1), 90.0), 200),
        evaluation(body(0.5), reward(1), 5.0),
        cut(evaluation(body(0.7), reward(1), 95.0), 500),
        evaluation(body(0.9), reward(1), 7.0),
    ]
    entries = morphology_entries(SWIMMER, "fitness", reward(1), measured)
    assert "m³) after only 200 of 1,000 training steps" in entries[0].text
    assert "steps" not in entries[1].text
    assert choose(entries, HistorySettings(10_000, "best")) == [3, 1, 2, 0]
    assert choose(entries, HistorySettings(10_000, "worst")) == [0, 2, 1, 3]


def test_a_morphology_counts_by_its_longest_training() -> None:
    mixed = [
        cut(evaluation(body(0.3), reward(1), 90.0), 200),
        evaluation(body(0.3), reward(2), 5.0),
    ]
    (entry,) = morphology_entries(SWIMMER, "fitness", reward(3), mixed)
    assert (entry.score, entry.steps) == (5.0, 1000)
    assert "With reward 2, its best: efficiency" in entry.text
    assert "(fitness 5 m" in entry.text.split("its best")[1].split("\n")[0]


def test_the_learning_curve_is_a_few_points() -> None:
    steps = tuple(range(100, 6500, 100))
    series = {
        "episode_return": (None, *(float(i) for i in range(1, 64))),
        "episode_length": tuple(10.0 * i for i in range(64)),
    }
    curve = Curve(steps, series)
    measured = [evaluation(body(0.3), reward(1), 5.0)]
    keys = []

    def curve_of(key: str) -> Curve:
        keys.append(key)
        return curve

    (entry,) = morphology_entries(SWIMMER, "fitness", reward(1), measured, curve_of)
    assert "return of an episode 6 at 700, 16 at 1,700, 32 at 3,300" in entry.text
    assert "its length in control steps 60 at 700" in entry.text and "630 at 6,400" in entry.text
    assert keys == [measured[0].key]
    assert curve_line(Curve((1,), {"loss/actor": (1.0,)})) == ""


def test_our_own_tracebacks_are_not_shown() -> None:
    ours = replace(
        evaluation(body(), reward(), None, 'Traceback: File "/home/me/robomore/evaluate.py"'),
        status=Status.FAILED,
    )
    (entry,) = morphology_entries(SWIMMER, "efficiency", reward(), [ours])
    assert "/home" not in entry.text and "nothing to do with the design" in entry.text


def test_a_long_diagnosis_is_cut() -> None:
    (entry,) = morphology_entries(
        SWIMMER, "efficiency", reward(), [evaluation(body(), reward(), None, "long " * 500)]
    )
    assert len(entry.text) < 700


@pytest.mark.parametrize("tokens", [0, 10, 100, 1000, 100_000])
def test_the_sentence_on_the_selection_is_true(tokens: int) -> None:
    measured = [evaluation(body(0.1 + i / 50), reward(), i) for i in range(40)]
    entries = morphology_entries(SWIMMER, "efficiency", reward(), measured)
    selected = select(entries, HistorySettings(tokens), "morphologies")
    shown = selected.entries.count("## Morphology")
    if shown == 40:
        assert "all 40 morphologies" in selected.selection
    else:
        assert f"These are {shown} of the 40 morphologies" in selected.selection
        assert all(words in selected.selection for words in list(RULES.values())[:4])
    assert estimate_tokens(selected.entries) <= max(tokens, 10)


def test_nothing_measured_yet() -> None:
    assert "no morphologies" in select([], HistorySettings(), "morphologies").selection
