"""Found rewards against the reference reward, on finals with numbers that a test knows."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from robomore.runs import Run
from robomore.studies.crossed import group_score, reward_table
from robomore.studies.study import Results


def trained(score: float | None, reward: str, key: str = "") -> Any:
    measured = None if score is None else SimpleNamespace(mean=score)
    return SimpleNamespace(
        evaluations=(SimpleNamespace(key=key),),
        score=lambda objective: measured,
        design=SimpleNamespace(reward=SimpleNamespace(source=reward)),
    )


def final(found: float | None, plain: float | None, reward: str = "found") -> Run:
    run = SimpleNamespace(
        found=trained(found, reward, f"{found}/{plain}"),
        morphology_only=trained(plain, "reference"),
        reference=trained(1.0, "reference"),
        objective="efficiency",
    )
    return cast(Run, run)


def row(*runs: Run) -> dict[str, Any]:
    cell = SimpleNamespace(task="swimmer", arm=SimpleNamespace(name="any"))
    results = Results(tuple((cast(Any, cell), run) for run in runs))
    table = reward_table(results)
    (only,) = table.rows
    return dict(zip(table.columns, only, strict=True))


def test_the_mean_is_geometric_so_that_halves_and_doubles_cancel_out() -> None:
    found = row(final(2.0, 1.0), final(1.0, 2.0), final(3.0, 3.0))
    assert found["geometric mean"] == pytest.approx(1.0)
    assert found["found is better"] == "1 of 3" and found["95 % from"] is None


def test_five_pairs_give_an_interval_around_the_mean() -> None:
    found = row(*(final(value, 10.0) for value in (5.0, 8.0, 10.0, 12.0, 9.0)))
    assert 0.5 < found["95 % from"] < found["geometric mean"] < found["95 % to"] < 1.3


def test_two_arms_with_one_answer_are_one_pair() -> None:
    found = row(final(4.0, 1.0), final(4.0, 1.0), final(1.0, 1.0))
    assert found["geometric mean"] == pytest.approx(2.0)
    assert found["found is better"] == "1 of 2"


def test_runs_that_kept_the_reference_reward_are_counted_and_others_left_out() -> None:
    found = row(final(4.0, 2.0), final(9.0, 9.0, "reference"), final(-1.0, 2.0), final(None, 2.0))
    assert found["geometric mean"] == pytest.approx(2.0)
    assert found["found is better"] == "1 of 1" and found["found none"] == 1


def test_no_pair_gives_no_number() -> None:
    assert row(final(None, None))["geometric mean"] is None
    assert group_score(final(None, 1.0), "found", "efficiency") is None
