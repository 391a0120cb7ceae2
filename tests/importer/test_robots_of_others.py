"""Robots that others made, from their file to a champion without an edit: `make test-robots`."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from robomore.cli.app import main
from robomore.runs import load_run

pytestmark = pytest.mark.robots

ROBOTS = {
    "go1": ("mjlab", "asset_zoo/robots/unitree_go1/xmls/go1.xml"),
    "g1": ("mjlab", "asset_zoo/robots/unitree_g1/xmls/g1.xml"),
    "quadruped": ("dm_control", "suite/quadruped.xml"),
    "upkie": ("upkie_description", "urdf/upkie.urdf"),
    "ur5e": ("ogbench", "manipspace/descriptions/universal_robots_ur5e/ur5e.xml"),
}
"""Package and file of each robot. None of the packages is imported."""


@pytest.mark.parametrize("name", ROBOTS)
def test_from_a_file_to_a_champion(name: str, tmp_path: Path) -> None:
    package, inside = ROBOTS[name]
    found = importlib.util.find_spec(package)
    if found is None or not found.submodule_search_locations:
        pytest.skip(f"{package} is not installed; make test-robots does that")
    folder, run = tmp_path / name, tmp_path / "run"
    assert (
        main(["new", str(Path(found.submodule_search_locations[0]) / inside), "--out", str(folder)])
        == 0
    )
    file = folder / "task.toml"
    assert main(["run", str(file), "--preset", "smoke", "--out", str(run), "--workers", "1"]) == 0
    champion = load_run(run).champion
    assert champion is not None and (run / "champion" / "policy.npz").is_file()
