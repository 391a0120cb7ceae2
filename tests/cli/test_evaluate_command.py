"""`evaluate`: one design, trained and measured; its status decides how the command ends."""

from __future__ import annotations

from pathlib import Path

import pytest

import robomore.experiment
from cli.commands import Command
from robomore.tasks import get_task
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status, TrainerSettings


def evaluation(status: Status = Status.OK) -> Evaluation:
    design = Design(Morphology(get_task("swimmer").reference), Reward(get_task("swimmer").reward))
    job = Job("swimmer", design, TrainerSettings(), 1_000, 2, 0)
    if status is not Status.OK:
        return Evaluation("key", job, status, "line 3: NameError")
    return Evaluation(
        "key",
        job,
        status,
        fitness=2.0,
        volume=0.1,
        efficiency=20.0,
        episode_fitness=(1.0, 3.0),
        behaviour={"forward_speed_m_s": 0.5, "fell_share": 0.25},
    )


@pytest.mark.parametrize(("status", "code"), [(Status.OK, 0), (Status.REWARD_FAILED, 1)])
def test_evaluate_prints_the_evaluation_and_its_status_decides_the_exit(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, status: Status, code: int
) -> None:
    monkeypatch.setattr(robomore.experiment, "evaluate", lambda *_, **__: evaluation(status))
    said = robomore_("evaluate", "swimmer", "--preset", "smoke", "--json")
    assert said.status == code
    assert said.json["status"] == status
    assert ("NameError" in said.json["diagnosis"]) == bool(code)
    out = robomore_("evaluate", "swimmer", "--preset", "smoke").out
    assert str(status) in out
    for line in ("forward speed (m/s): 0.5", "episodes that ended in a fall: 25.0 %"):
        assert (line in out) == (status is Status.OK)


def test_evaluate_keeps_a_design_that_can_be_named_again(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(robomore.experiment, "evaluate", lambda *_, **__: evaluation())
    out = tmp_path / "mine"
    assert robomore_("evaluate", "swimmer", "--out", out).status == 0
    data = robomore_("inspect", "swimmer", "--parameters", out / "design.json", "--json").json
    assert list(data["parameters"].values()) == list(get_task("swimmer").reference)
    assert "is not empty" in robomore_("evaluate", "swimmer", "--out", out).err
