"""A champion of each of the eight tasks, exported and used by programs that know no RoboMoRe."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from exhaustive import more_of
from export.reading import same_robot
from robomore.experiment import run
from robomore.export import export_run
from robomore.tasks.registry import PAPER_TASKS
from tiny import TINY

_EPISODES = 5

PLAY = """
import importlib, json, sys
import numpy as np, onnxruntime
package = sys.argv[1]
act = importlib.import_module(package).act
measure = importlib.import_module(package + ".measure")
session = onnxruntime.InferenceSession(sys.argv[2])
apart = 0.0
def onnx(observations):
    global apart
    (actions,) = session.run(None, {"observation": np.float32(observations)})
    apart = max(apart, float(np.abs(actions - act(observations)).max()))
    return actions
seeds = measure.RECORDED["seeds"]
found = {"numpy": measure.measure(seeds), "onnx": measure.measure(seeds, onnx), "apart": apart}
assert not [name for name in sys.modules if name.partition(".")[0] in ("robomore", "jax")]
print(json.dumps(found))
"""


@pytest.mark.parametrize("task", more_of([one.id for one in PAPER_TASKS], "swimmer"))
def test_a_champion_lives_elsewhere(task: str, tmp_path: Path) -> None:
    settings = replace(TINY, final=replace(TINY.final, episodes=_EPISODES))
    trained = run(task, settings, seed=1, workers=1, out=tmp_path / "run")
    out = tmp_path / "out"
    done = export_run(trained, out, video_seconds=0.0)

    model = mujoco.MjModel.from_xml_path(str(out / "robot" / "robot.xml"))
    same_robot(model, out / "robot" / "robot.urdf")

    record = json.loads((out / "export.json").read_text())
    for piece in record["pieces"]:
        mesh = trimesh.load_mesh(out / "print" / f"{piece['name']}.stl")
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(piece["volume_mm3"], rel=1e-3)

    (package,) = (path for path in (out / "environment").iterdir() if path.is_dir())
    command = [sys.executable, "-c", PLAY, package.name, str(out / "policy" / "policy.onnx")]
    answer = subprocess.run(
        command, cwd=package.parent, capture_output=True, text=True, check=True, timeout=600
    )
    found = json.loads(answer.stdout)
    assert found["apart"] < 1e-5
    recorded = json.loads((package / "recorded.json").read_text())["episode_fitness"]
    assert len(recorded) == _EPISODES
    slack = max(0.02, max(recorded) - min(recorded))
    assert np.mean(found["numpy"]) == pytest.approx(np.mean(recorded), abs=slack)
    assert np.mean(found["onnx"]) == pytest.approx(np.mean(recorded), abs=slack)
    assert done.fitness == pytest.approx(np.mean(found["numpy"]), abs=1e-9)
