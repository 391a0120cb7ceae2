"""What a language model is told of a run: how designs are trained, and how training went."""

from __future__ import annotations

from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path

from designers.evaluations import evaluation
from robomore.experiment.designing import _Curves
from robomore.experiment.training_facts import training_facts
from robomore.settings import preset, with_trainer
from robomore.store import Ledger, RunFolder
from robomore.tasks import get_task
from robomore.types import Curve, Morphology

SWIMMER = get_task("swimmer")
CURVE = Curve((10, 20), {"episode_return": (1.0, 2.0)})


def test_curves_come_from_the_ledger_also_those_that_are_written_later(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    measured = [
        evaluation(SWIMMER, Morphology(SWIMMER.reference), fitness=i) for i in (1.0, 2.0, 3.0)
    ]
    measured = [replace(one, key=f"e{i}") for i, one in enumerate(measured)]
    with closing(Ledger(folder.ledger)) as ledger, ExitStack() as stack:
        ledger.add_evaluation(replace(measured[0], curve=CURVE))
        curves = _Curves(folder, stack)
        assert curves.curve("e0") == CURVE
        ledger.add_evaluation(measured[1])
        ledger.add_evaluation(replace(measured[2], curve=CURVE))
        assert curves.curve("e1") is None
        assert curves.curve("e2") == CURVE


def test_what_trains_is_that_of_the_robot() -> None:
    quick = preset("quick")
    facts = training_facts(quick, SWIMMER)
    assert (facts.algorithm, facts.gamma, facts.steps) == ("crossq", 0.999, quick.candidate.steps)
    assert facts.normalizes_reward and facts.num_envs and facts.episodes == quick.candidate.episodes
    paper = training_facts(with_trainer(quick, "sac", {"gamma": 0.9}), get_task("hopper"))
    assert (paper.algorithm, paper.gamma, paper.episode_seconds) == ("sac", 0.9, None)
    assert "about 10 control steps ahead" in str(paper)
