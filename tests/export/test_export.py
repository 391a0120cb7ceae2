"""A whole export: the exported code alone reaches the recorded fitness, and nothing leaks out."""

from __future__ import annotations

import ast
import hashlib
import importlib
import json
import shutil
import subprocess
import sys
import tomllib
import zipfile
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium
import hatchling.build
import numpy as np
import onnxruntime
import pytest

from dog import write_dog
from robomore.envs.registration import make_environment
from robomore.envs.robots import environment_class
from robomore.errors import ExportFailed, InputError
from robomore.evaluation.measure import measure
from robomore.export import export_run
from robomore.export.card import _numbers
from robomore.export.environment import environment_package
from robomore.export.export import _run_alone
from robomore.export.folder import PARTS, ensure_free, write_all
from robomore.export.policies import numpy_module
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.runs import Run, load_run
from robomore.tasks.portable import task_content, task_from_content
from robomore.training.policy import MLPPolicy
from robomore.types import Design, Evaluation, Morphology, Reward
from shared import made_once


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory, trained_run: Path) -> Path:
    def make(out: Path) -> None:
        export_run(load_run(trained_run), out, video_seconds=0.2)

    return made_once(tmp_path_factory, "exported", make)


@pytest.fixture
def package(exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The exported package, built and unpacked as `pip install` does it."""
    monkeypatch.chdir(shutil.copytree(exported / "environment", tmp_path / "source"))
    wheel = hatchling.build.build_wheel(str(tmp_path))
    with zipfile.ZipFile(tmp_path / wheel) as packed:
        packed.extractall(tmp_path / "site")
    monkeypatch.syspath_prepend(tmp_path / "site")
    return importlib.import_module("swimmer_champion")


def test_the_exported_code_alone_reaches_the_recorded_fitness(exported: Path) -> None:
    code = (
        "import json, sys, swimmer_champion.measure as m; import swimmer_champion\n"
        "found = m.measure(m.RECORDED['seeds'])\n"
        "assert not [n for n in sys.modules if n.partition('.')[0] in ('robomore', 'jax')]\n"
        "print(json.dumps([found, m.RECORDED['episode_fitness']]))"
    )
    done = subprocess.run(
        [sys.executable, "-B", "-c", code],
        cwd=exported / "environment",
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    found, recorded = json.loads(done.stdout)
    np.testing.assert_allclose(found, recorded, rtol=1e-3)


def test_the_onnx_policy_reaches_it_too(exported: Path, package: ModuleType) -> None:
    session = onnxruntime.InferenceSession(exported / "policy" / "policy.onnx")

    def act(observations: Any) -> Any:
        (actions,) = session.run(None, {"observation": np.float32(observations)})
        np.testing.assert_allclose(actions, package.act(observations), atol=1e-5)
        return actions

    measure = importlib.import_module("swimmer_champion.measure")
    found = measure.measure(measure.RECORDED["seeds"], act)
    # A policy that has hardly learned turns a difference in the last digit into another motion.
    np.testing.assert_allclose(found, measure.RECORDED["episode_fitness"], rtol=0.2)


def test_a_diverged_episode_is_worth_what_it_was_when_recorded(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    measure = importlib.import_module("swimmer_champion.measure")

    class Bursting(package.env.Robot):  # type: ignore[name-defined, misc]
        def step(self, action: Any) -> Any:
            result = super().step(action)
            self.data.qpos[0] = 50.0  # far from its start, and nowhere in the step after
            self.data.qvel[1] = np.nan if self.data.time > 1.0 else 0.0
            return result

    monkeypatch.setattr(measure, "Robot", Bursting)
    assert measure.measure(measure.RECORDED["seeds"][:1]) == [0.0]


def test_the_throw_that_ends_an_episode_counts_as_little_as_when_recorded(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    measure = importlib.import_module("swimmer_champion.measure")

    class Thrown(package.env.Robot):  # type: ignore[name-defined, misc]
        _healthy_z_range = (0.2, 1.0)

        def step(self, action: Any) -> Any:
            observation, reward, _, cut, facts = super().step(action)
            return observation, reward, self.data.time > 1.0, cut, facts

    def root(robot: Any) -> tuple[float, float]:
        return (50.0, 90.0) if robot.data.time > 1.0 else (robot.data.time, 0.5)

    monkeypatch.setattr(measure, "Robot", Thrown)
    monkeypatch.setattr(measure, "root", root)
    assert measure.measure(measure.RECORDED["seeds"][:1]) == [pytest.approx(1.0, abs=0.05)]
    monkeypatch.setattr(measure, "FITNESS", "height")
    assert measure.measure(measure.RECORDED["seeds"][:1]) == [0.5]


def test_the_package_gives_the_reward_that_was_trained_with(
    trained_run: Path, package: ModuleType
) -> None:
    run = load_run(trained_run)
    assert run.champion is not None
    design = run.champion.design
    theirs = gymnasium.make(package.ID)
    mine = make_environment("swimmer", design.morphology.parameters, design.reward.source)
    assert theirs.spec is not None and theirs.spec.max_episode_steps == 1000
    seen, ours = theirs.reset(seed=3)[0], mine.reset(seed=3)[0]
    for _ in range(20):
        assert np.array_equal(seen, ours)
        action = package.act(seen)
        seen, reward, *_ = theirs.step(action)
        ours, expected, *_ = mine.step(action)
        assert reward == expected


def test_the_card_says_whose_numbers_these_are(trained_run: Path) -> None:
    run = load_run(trained_run)
    best = run.kept()
    for chosen, whose in (
        (run, "the best training seed"),
        (run.focused(best.key), f"the evaluation `{best.key}`"),
    ):
        said = "\n".join(_numbers(chosen, best, best.episode_fitness))
        assert f"which is that of {whose}:" in said


def test_the_folder_holds_what_its_record_says(exported: Path) -> None:
    record = json.loads((exported / "export.json").read_text())
    files = {p.relative_to(exported).as_posix() for p in exported.rglob("*") if p.is_file()}
    assert files == {*record["sha256"], "export.json"}
    assert {name.partition("/")[0] for name in record["sha256"]} <= set(PARTS)
    for name, digest in record["sha256"].items():
        assert hashlib.sha256((exported / name).read_bytes()).hexdigest() == digest
    assert {"robot/robot.xml", "robot/robot.urdf", "policy/policy.onnx"} <= files
    assert {"print/whole.stl", "print/whole.3mf", "video.webp", "README.md"} <= files
    card = (exported / "README.md").read_text()
    assert "| whole | " in card
    assert "Integrator in training: implicitfast at half the timestep" in card  # Swimmer has RK4
    # The word stands where a piece fits a bed of 256 mm, and nowhere else.
    fits = [max(piece["extent_mm"]) <= 256 for piece in record["pieces"]]
    assert [piece["printable"] for piece in record["pieces"]] == fits and not fits[-1]
    assert card.count("printable") == sum(fits)


def test_only_a_free_folder_is_written(exported: Path, trained_run: Path, tmp_path: Path) -> None:
    run = load_run(trained_run)
    full = tmp_path / "full"
    full.mkdir()
    (full / "README.md").write_text("mine")
    for force in (False, True):
        with pytest.raises(InputError, match="not empty and no export"):
            export_run(run, full, force=force)
    assert (full / "README.md").read_text() == "mine"
    copy = shutil.copytree(exported, tmp_path / "copy")
    with pytest.raises(InputError, match="--force"):
        export_run(run, copy)
    (copy / "notes.txt").write_text("mine")
    ensure_free(copy, force=True)
    write_all(copy, {"README.md": b"new"}, {})
    assert sorted(p.name for p in copy.iterdir()) == ["README.md", "export.json", "notes.txt"]


def test_an_export_is_replaced_and_nothing_else(exported: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(exported, tmp_path / "copy")
    mine = [copy / "print" / "sliced" / "mine.gcode", copy / "robot" / "notes.txt"]
    for path in mine:
        path.parent.mkdir(exist_ok=True)
        path.write_text("mine")
    ensure_free(copy, force=True)
    write_all(copy, {"README.md": b"new", "robot/robot.xml": b"new"}, {})
    left = {p.relative_to(copy).as_posix() for p in copy.rglob("*") if p.is_file()}
    assert left == {
        *("README.md", "export.json", "robot/robot.xml"),
        *("print/sliced/mine.gcode", "robot/notes.txt"),
    }
    assert not (copy / "environment").exists() and not (copy / "policy").exists()
    # What was edited is the editor's, and so is what has a name that an export wants.
    (copy / "robot" / "robot.xml").write_text("edited")
    with pytest.raises(InputError, match=r"changed after they were exported \(robot/robot.xml\)"):
        ensure_free(copy, force=True)
    (copy / "robot" / "robot.xml").write_bytes(b"new")
    for name, said in (
        ("robot/notes.txt", "of your own where the export has one"),
        ("print/sliced/mine.gcode/x", "a file where a folder is expected"),
    ):
        with pytest.raises(InputError, match=said):
            write_all(copy, {name: b"ours"}, {})
    assert [path.read_text() for path in mine] == ["mine", "mine"]
    assert (copy / "robot" / "robot.xml").read_bytes() == b"new"


@pytest.mark.parametrize("names", [["../out.txt", "notes.txt"], None, {"a": 1}, "x"])
def test_a_foreign_record_removes_nothing_else(names: object, tmp_path: Path) -> None:
    folder = tmp_path / "export"
    folder.mkdir()
    for path in (tmp_path / "out.txt", folder / "notes.txt"):
        path.write_text("kept")
    sums = dict.fromkeys(names, "0") if isinstance(names, list) else names
    record = {"made_by": "robomore export", "sha256": sums}
    (folder / "export.json").write_text(json.dumps(record))
    ensure_free(folder, force=True)
    write_all(folder, {"README.md": b"new"}, {})
    assert (tmp_path / "out.txt").read_text() == (folder / "notes.txt").read_text() == "kept"


def test_links_in_the_folder_are_not_followed(exported: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "kept.txt").write_text("kept")
    copy = shutil.copytree(exported, tmp_path / "copy")
    shutil.rmtree(copy / "policy")
    (copy / "policy").symlink_to(outside)
    with pytest.raises(InputError, match="symbolic link"):
        ensure_free(copy, force=True)
    with pytest.raises(InputError, match="symbolic link"):
        write_all(copy, {"policy/policy.py": b"new"}, {})
    assert [p.name for p in outside.iterdir()] == ["kept.txt"]
    for name in ("../out.txt", "elsewhere/x", "/etc/x"):
        with pytest.raises(ValueError, match="no part of an export"):
            write_all(copy, {name: b""}, {})


def test_a_policy_that_fits_no_robot_is_named(
    trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = load_run(trained_run)
    odd = MLPPolicy((np.ones((3, 2), np.float32),), (np.zeros(2, np.float32),))
    monkeypatch.setattr(Run, "load_policy", lambda self, key=None: odd)
    with pytest.raises(InputError, match="trainer 'crossq' takes 3 numbers and gives 2"):
        export_run(run, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_task_of_somebody_else_needs_robomore(trained_run: Path, exported: Path) -> None:
    run = load_run(trained_run)
    assert run.champion is not None
    own = replace(run, task=replace(run.task, id="own", environment="their.robots:Robot"))
    evaluation = run.champion.best("efficiency")
    mjcf = (exported / "robot" / "robot.xml").read_text()
    files = environment_package(own, evaluation, "champion", mjcf, "")
    assert "robomore==" in files["pyproject.toml"].decode()
    assert "carried_task('own'" in files["own_champion/env.py"].decode()
    assert files["own_champion/task.json"] == b""


FUNCTION = """{ unit = "m", meaning = "far", function = '''
def fitness(trajectory):
    return trajectory.distance
''' }"""


@pytest.mark.parametrize(
    "fitness",
    [
        '{ measure = "speed-kept", options = { speed = 0.5 } }',
        '[{ measure = "time-upright", weight = 2 }, { measure = "energy", weight = -0.001 }]',
    ],
)
def test_a_package_measures_whatever_a_task_file_is_about(
    fitness: str, trained_run: Path, tmp_path: Path
) -> None:
    run, evaluation, policy = of_a_dog(fitness, trained_run, tmp_path)
    measured = measure(run.task, run.task.reference, policy, 2, seed=evaluation.job.seed)
    evaluation = replace(evaluation, episode_fitness=measured.episode_fitness)
    files = environment_package(run, evaluation, "x", "", numpy_module(policy, "dog"))
    assert _run_alone(files, "dog_x", evaluation) == pytest.approx(measured.episode_fitness)


def test_a_function_of_a_task_file_stays_in_its_run(trained_run: Path, tmp_path: Path) -> None:
    run, evaluation, _ = of_a_dog(FUNCTION, trained_run, tmp_path)
    environment_package(run, evaluation, "x", "", "")
    content = task_content(task_from_content(task_content(run.task), trusted=False))
    foreign = replace(run, task=task_from_content(content))
    with pytest.raises(ExportFailed, match="dog is a function of its task file, which is not"):
        environment_package(foreign, evaluation, "x", "", "")


EVIL = '")\n\n\nimport os\n"""\nPWNED = os.environ\n' + "'''\nPWNED = 1\n"


@pytest.mark.parametrize("fitness", ['"distance"', FUNCTION])
def test_what_a_task_says_is_no_code(fitness: str, trained_run: Path, tmp_path: Path) -> None:
    run, evaluation, _ = of_a_dog(fitness, trained_run, tmp_path)
    if fitness == '"distance"':
        run = load_run(trained_run)  # Its package is the other one, without RoboMoRe.
        assert run.champion is not None
        evaluation = run.champion.best("efficiency")
    goal = replace(run.task.goal, unit=EVIL)
    forged = replace(run, task=replace(run.task, title=EVIL, description=EVIL, fitness=goal))
    files = environment_package(forged, evaluation, "x", "", "")
    for file, text in files.items():
        if file.endswith(".py"):
            names = [one.id for one in ast.walk(ast.parse(text)) if isinstance(one, ast.Name)]
            assert "PWNED" not in names, file
    assert tomllib.loads(files["pyproject.toml"].decode())["project"].keys() == {
        *("name", "version", "description", "requires-python", "dependencies")
    }


def test_what_was_made_of_a_run_gets_no_keys(
    trained_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SECRET_API_KEY", "sk-1")
    says = b"import json, os; print(json.dumps([float('SECRET_API_KEY' in os.environ)]))"
    champion = load_run(trained_run).champion
    assert champion is not None
    found = _run_alone({"nosy/__main__.py": says}, "nosy", champion.best("efficiency"))
    assert found == [0.0]


def of_a_dog(fitness: str, trained_run: Path, folder: Path) -> tuple[Run, Evaluation, MLPPolicy]:
    """Return a run, as if it had been one of a task file with this fitness, and what it gave."""
    source = write_dog(folder)
    file = write_proposal(read_robot(source), source, folder / "dog")
    file.write_text(file.read_text().replace('"distance"', fitness))
    task, run = read_task(file), load_run(trained_run)
    assert run.champion is not None
    design = Design(Morphology(task.reference), Reward(task.reward))
    best = run.champion.best("efficiency")
    evaluation = replace(best, job=replace(best.job, design=design))
    robot = environment_class(task)(task, task.reference, lambda *_: (0.0, {}))
    sizes = robot.observation_space.shape[0], robot.action_space.shape[0]
    policy = MLPPolicy((np.full(sizes, 0.01, np.float32),), (np.zeros(sizes[1], np.float32),))
    return replace(run, task=task), evaluation, policy
