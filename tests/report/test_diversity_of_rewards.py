"""How different the rewards of a run are, however long somebody makes them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fake_run import SETTINGS, FakeRun
from robomore.report.diversity import diversity
from robomore.runs import load_run
from robomore.types import Design, MethodSettings, Place, Reward


def test_of_very_long_rewards_the_beginning_is_compared(tmp_path: Path) -> None:
    """Each has half a million different words after it, which would take minutes."""
    same = "x_velocity = x_velocity * 1.0\n" * 400
    run = FakeRun(tmp_path / "run", settings=replace(SETTINGS, method=MethodSettings("random")))
    for n in range(4):
        words = "".join(f"a{n}b{i}\n" for i in range(20_000))
        design = Design(run.morphology(1 - 0.2 * n), Reward(same + words))
        run.add(design, Place(stage="samples", index=(n,)), 10.0 + n)
    found = diversity(load_run(run.path))
    assert found is not None
    facts = dict(found.facts)
    assert facts["different rewards"] == "4"
    assert facts["Self-BLEU of the rewards (less is more diverse)"] == "1.000"
