"""Diversity of proposals: what repeats an earlier one counts, too."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import stdev

import numpy as np
import pytest

from fake_run import FakeRun
from robomore.runs import load_run
from robomore.runs.lineage import Record
from robomore.statistics import coefficient_of_variation
from robomore.studies.diversity import DIVERSITY, _deviation, _first, _self_bleu, _variation
from robomore.studies.study import Cell, Results
from robomore.tasks import get_task
from robomore.types import Design, Morphology, Place, Reward
from search.fakes import evaluation


def grid(morphologies: Sequence[Sequence[float]], rewards: list[str]) -> list[Record]:
    return [
        Record(
            Place(stage="coarse", index=(row, column)),
            evaluation(Design(Morphology(tuple(values)), Reward(text)), 1.0),
        )
        for row, values in enumerate(morphologies)
        for column, text in enumerate(rewards)
    ]


def test_repeated_morphologies_lower_the_variation() -> None:
    found = _variation(grid([[1.0], [2.0], [2.0], [2.0]], ["r"]))
    assert found == pytest.approx(coefficient_of_variation([(1.0,), (2.0,), (2.0,), (2.0,)]))
    assert found < _variation(grid([[1.0], [2.0]], ["r"]))  # type: ignore[operator]
    assert _variation(grid([[1.0]], ["r", "s"])) is None


def test_the_deviation_is_over_the_range_and_does_not_depend_on_where_zero_is() -> None:
    walker = get_task("walker")
    foot = walker.names.index("foot_back")  # a signed coordinate, whose reference is 0
    low, high = (getattr(walker.searched().parameters[foot], end) for end in ("low", "high"))

    def proposals(*shares: float) -> list[tuple[float, ...]]:
        rows = [list(walker.reference) for _ in shares]
        for row, share in zip(rows, shares, strict=True):
            row[foot] = low + share * (high - low)
        return [tuple(row) for row in rows]

    zero = -low / (high - low)
    around, beside = (
        proposals(*(start + step for step in (-0.1, 0.0, 0.11))) for start in (zero, zero + 0.2)
    )
    wild, tame = (coefficient_of_variation(rows) for rows in (around, beside))
    assert wild > 10 * tame
    expected = stdev([-0.1, 0.0, 0.11]) / len(walker.parameters)
    for rows in (around, beside):
        found = _deviation(walker, grid(rows, ["r", "s"]))
        assert found == pytest.approx(expected, abs=1e-4)
    ends = np.array([(one.low, one.high) for one in walker.searched().parameters])
    drawn = np.random.default_rng(0).uniform(*ends.T, (2000, len(ends))).tolist()
    assert _deviation(walker, grid(drawn, ["r"])) == pytest.approx(12**-0.5, abs=0.01)
    assert _deviation(walker, grid(around[:1], ["r", "s"])) is None


def test_proposals_beyond_the_search_range_have_a_deviation() -> None:
    ant = get_task("ant")
    hip = ant.names.index("hip_x")  # searched above 0.01 by its logarithm, and negative if proposed
    rows = [list(ant.reference) for _ in range(2)]
    rows[0][hip] = -rows[1][hip]
    assert (_deviation(ant, grid(rows, ["r"])) or 0) > 0


def test_pairs_that_failed_are_in_no_mean_and_the_table_says_so(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse())  # one of twelve pairs fails
    loaded = load_run(tmp_path)
    cell = Cell("swimmer", DIVERSITY.arms[0], 0, loaded.manifest.settings, 12_000)
    (table,) = DIVERSITY.tables(Results(((cell, loaded),)))
    row = dict(zip(table.columns, table.rows[0], strict=True))
    assert row["pairs"] == "11 of 12"
    assert "failed are in neither" in table.note
    assert row["deviation over the search range"] == _deviation(loaded.task, _first(loaded))


def test_repeated_rewards_raise_the_self_bleu() -> None:
    texts = ["forward = self.speed + 1", "effort = -2 * abs(action)"]
    assert _self_bleu(grid([[1.0], [2.0]], [texts[0]] * 3)) == 1.0
    apart, repeated = (_self_bleu(grid([[1.0]], found)) for found in (texts, [*texts, texts[0]]))
    assert apart is not None and repeated is not None and apart < repeated
    assert _self_bleu(grid([[1.0], [2.0]], texts[:1])) is None


def test_comments_are_no_words() -> None:
    one, other = "forward = speed  # as fast as it can", "# another idea\nforward = speed"
    assert _self_bleu(grid([[1.0]], [one, other])) == pytest.approx(1.0)
