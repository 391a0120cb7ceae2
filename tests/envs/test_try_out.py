"""What the short try accepts, what it refuses, and what it says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from paper import PUBLISHED
from robomore.envs import try_out as module
from robomore.envs.try_out import try_out
from robomore.errors import InvalidMorphology, UnstableSimulation
from robomore.tasks import get_task

SHORT = 20
"""Control steps of each simulation: enough for what diverges at once, and quick."""


@pytest.mark.parametrize("id", PUBLISHED)
def test_every_published_morphology_is_simulated(id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STEPS", SHORT)
    for row in PUBLISHED[id]:
        try_out(get_task(id), row)


@pytest.mark.exhaustive
@pytest.mark.parametrize("id", PUBLISHED)
def test_every_published_morphology_is_simulated_for_the_whole_try(id: str) -> None:
    for row in PUBLISHED[id]:
        try_out(get_task(id), row)


@pytest.mark.parametrize(
    ("parameters", "joint"),
    [
        ([0.352, 0.082, 0.794, 0.483, 0.078, 0.007], "motor2_rot"),
        ([0.247, 0.637, 0.658, 0.005, 0.006, 0.01], "slider2"),
    ],
)
def test_a_swimmer_too_light_for_its_fluid_is_found_by_trying(
    parameters: list[float],
    joint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    task = get_task("swimmer")
    said = set()
    for _ in range(2):
        with pytest.raises(UnstableSimulation, match=rf"diverged 2 times .*{joint}.*kg") as refused:
            try_out(task, task.check(parameters))
        said.add(str(refused.value))
    assert len(said) == 1, "the same try for the same morphology"
    assert capfd.readouterr() == ("", "") and not list(tmp_path.iterdir())


def test_a_robot_that_starts_too_high_to_be_healthy_is_refused_with_its_height() -> None:
    ant = get_task("ant")
    tall = dict(zip(ant.names, ant.reference, strict=True)) | {"foot_x": 2.5, "foot_y": 2.5}
    with pytest.raises(InvalidMorphology, match=r"all 16 episodes .* 3\.\d+ m high.*0.1 to 2.3 m"):
        try_out(ant, ant.check(tall))
    powered = replace(get_task("ant-powered"), template=ant.template)
    try_out(powered, powered.check(tall))
