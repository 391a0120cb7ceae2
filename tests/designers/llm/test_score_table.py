"""The table of all results: its order, its spread, its causes, and its length."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from measured import SWIMMER, body, evaluation, grid, reward

from robomore.designers.llm.score_table import Numbers, score_table, spread_sentence
from robomore.llm.tokens import estimate_tokens
from robomore.types import Evaluation


def shown(history: list[Evaluation], tokens: int = 10_000, parameters: bool = True) -> list[str]:
    numbers = Numbers(history)
    return score_table(SWIMMER, "efficiency", history, numbers, tokens, parameters).split("\n")


def other_seed(one: Evaluation, factor: float) -> Evaluation:
    return replace(
        one,
        key=f"{one.key}-again",
        job=replace(one.job, seed=1),
        efficiency=factor * one.efficiency,
    )


def test_designs_stand_in_the_order_of_their_scores_with_their_partners() -> None:
    measured = grid([body(0.3), body(0.7)], [reward(1), reward(2)])
    head, _, *rows = shown(measured)
    assert head.startswith("| efficiency (m/m³) | fitness (m) | volume (m³) | morphology | reward")
    assert "front_length" in head
    efficiencies = [float(row.split(" | ")[0].strip("| ")) for row in rows]
    assert efficiencies == sorted(efficiencies, reverse=True)
    assert [row.split(" | ")[3:5] for row in rows] == [[*"22"], [*"21"], [*"12"], [*"11"]]
    assert "front_length" not in shown(measured, parameters=False)[0]
    assert Numbers(measured).reward(measured[1].design) == "reward 2"
    assert Numbers(measured).reward_ideas()[1] == "- reward 2: Speed, 2 times."


def test_what_was_stopped_early_stands_below_and_what_failed_last() -> None:
    early = evaluation(body(0.3), reward(1), 90.0)
    early = replace(early, job=replace(early.job, steps=200))
    failed = evaluation(body(0.5), reward(1), None)
    done = evaluation(body(0.7), reward(1), 1.0)
    _, _, *rows = shown([early, failed, done])
    assert "| 100 % |" in rows[0] and "| 20 % |" in rows[1]
    assert "failed (reward-failed): line 3: division by zero" in rows[2]


def test_the_spread_over_episodes_and_seeds_is_shown() -> None:
    first = replace(evaluation(body(), reward(), 5.0), episode_fitness=(4.0, 5.0, 6.0))
    second = other_seed(first, 0.8)
    _, _, row = shown([first, second])
    assert f"| {first.efficiency:.4g}, {second.efficiency:.4g} | 5 ± 1, 5 ± 1 |" in row
    assert "No design was trained with a second seed" in spread_sentence([first], "efficiency")
    assert "differed by 22 %" in spread_sentence([first, second], "efficiency")


def test_the_cause_of_a_fall_is_named() -> None:
    moved = {"fell_share": 0.5, "fell_too_low_share": 0.25, "fell_too_high_share": 0.25}
    fallen = replace(evaluation(body(), reward(), 5.0), behaviour=moved)
    assert "50 % of episodes ended early (too low, too high)" in shown([fallen])[2]


@given(st.integers(0, 3000), st.integers(0, 60))
def test_the_table_keeps_to_its_tokens_and_says_what_it_leaves_out(tokens: int, count: int) -> None:
    measured = [evaluation(body(0.1 + 0.01 * i), reward(), float(i)) for i in range(count)]
    lines = shown(measured, tokens)
    rows = [line for line in lines if line.startswith("| ")][2:]
    assert estimate_tokens("\n".join(rows)) <= max(1, tokens)
    if len(rows) < count:
        assert f"{count - len(rows)} designs below these were left out for length." in lines[-1]
