"""The command line: what it prints, its exit statuses, and that every error is one line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import robomore.experiment
from fake_run import PROVENANCE, FakeRun, finished_run
from robomore.cli import main
from robomore.envs.vector_env import VectorEnv
from robomore.errors import Interrupted, NothingTrained
from robomore.store.champion import write_sums
from robomore.tasks import TASKS, get_task
from robomore.training.policy import MLPPolicy
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status, TrainerSettings


@dataclass
class Said:
    """What a command left."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


Command = Callable[..., Said]


@pytest.fixture
def robomore_(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run a command in this process."""

    def run(*arguments: str | Path) -> Said:
        capsys.readouterr()
        status = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return Said(status, out, err)

    return run


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / "finished"
    run = finished_run(path)
    simulations = VectorEnv(run.task, run.morphology(0.3).parameters, 1)
    shape = (simulations.observation_size, simulations.action_size)
    policy = MLPPolicy((np.ones(shape, np.float32),), (np.zeros(shape[1], np.float32),))
    policy.save(path / "champion" / "policy.npz")
    write_sums(path / "champion")
    return path


# Reading ------------------------------------------------------------------------------------------


def test_tasks_lists_all_eight(robomore_: Command) -> None:
    said = robomore_("tasks")
    assert said.status == 0
    assert all(name in said.out for name in TASKS)
    data = robomore_("tasks", "--json").json
    assert [task["id"] for task in data] == list(TASKS)
    assert len(data[5]["parameters"]) == 24


def test_inspect_gives_the_facts_of_the_human_body(robomore_: Command) -> None:
    data = robomore_("inspect", "swimmer", "--json").json
    assert data["volume"] == pytest.approx(0.106814, abs=5e-7)
    assert data["density"] == pytest.approx(1000.0)
    assert data["mass"] == pytest.approx(106.814, abs=1e-3)
    assert "rest_height" in data
    assert "{front_radius}" in data["masked_mjcf"]
    assert "{" not in data["mjcf"]
    assert data["picture"] is None


def test_inspect_takes_parameters_as_a_list_or_by_name(robomore_: Command, tmp_path: Path) -> None:
    values = [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]
    file = tmp_path / "body.json"
    found = []
    names = get_task("swimmer").names
    for content in (values, dict(zip(names, values, strict=True)), {"parameters": values}):
        file.write_text(json.dumps(content))
        found.append(robomore_("inspect", "swimmer", "--parameters", file, "--json").json)
    assert found[0] == found[1] == found[2]
    assert found[0]["volume"] == pytest.approx(get_task("swimmer").volume(values))


def test_inspect_draws_and_prints(robomore_: Command, tmp_path: Path) -> None:
    picture = tmp_path / "ant.svg"
    said = robomore_("inspect", "ant", "--picture", picture)
    assert said.status == 0
    assert "0.182176 m³" in said.out
    assert str(picture) in said.out
    assert picture.read_text().startswith("<svg")
    assert "{torso_radius}" in robomore_("inspect", "ant", "--mjcf", "masked").out


def test_show_prints_the_champion_and_who_proposed_it(robomore_: Command, finished: Path) -> None:
    said = robomore_("show", finished)
    assert said.status == 0
    assert PROVENANCE in said.out
    assert "7.50 (± 0.58) times the human design's efficiency" in said.out
    assert "fine: branch 1, cycle 1, new morphology" in said.out
    assert "def _get_rew" in said.out


def test_show_json_is_json_alone(robomore_: Command, finished: Path) -> None:
    said = robomore_("show", finished, "--json")
    assert said.err == ""
    assert said.json["champion"]["fitness"] == 13.0
    assert said.json["provenance"] == PROVENANCE


def test_show_of_a_run_that_goes_on(robomore_: Command, tmp_path: Path) -> None:
    FakeRun(tmp_path / "run").coarse()
    said = robomore_("show", tmp_path / "run")
    assert "not finished" in said.out
    assert "best so far" in said.out


def test_report_writes_where_it_is_told(robomore_: Command, finished: Path, tmp_path: Path) -> None:
    assert robomore_("report", finished).out.strip() == str(finished / "report.html")
    assert (finished / "report.html").stat().st_size > 10_000
    assert robomore_("report", finished, "--out", tmp_path / "page.html").status == 0
    assert (tmp_path / "page.html").is_file()


@pytest.mark.parametrize("part", ["", "champion", "champion/design.json"])
def test_play_writes_a_video_where_there_is_no_screen(
    robomore_: Command,
    finished: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    part: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    arguments = [finished / part, "--seconds", "1", "--drawn", "--out", tmp_path / "a.webp"]
    said = robomore_("play", *arguments)
    assert said.status == 0, said.err
    assert "40.00 s" in said.out or "40.0 s" in said.out
    from PIL import Image

    with Image.open(tmp_path / "a.webp") as video:
        assert video.size == (640, 360)
        assert getattr(video, "n_frames", 1) > 10


# Running ------------------------------------------------------------------------------------------


def test_run_passes_on_what_was_asked_and_prints_the_outcome(
    robomore_: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    asked: dict[str, Any] = {}

    def run(task: Any, settings: Any, out: Path, **options: Any) -> None:
        asked.update(options, settings=settings, task=task.id, out=out)
        finished_run(out)

    monkeypatch.setattr(robomore.experiment, "run", run)
    options = ["--preset", "smoke", "--seed", "5", "--workers", "3", "--steps", "900"]
    options += ["--trainer", "sac", "--trainer-option", "rate=1e-3"]
    options += ["--trainer-option", "hidden=[64,32]"]
    said = robomore_("run", "swimmer", *options, "--objective", "fitness", "--quiet")
    assert said.status == 0, said.err
    assert said.err == ""
    assert (asked["task"], asked["seed"], asked["workers"]) == ("swimmer", 5, 3)
    assert asked["settings"].candidate.steps == 900
    assert asked["settings"].search.objective == "fitness"
    assert asked["settings"].trainer == TrainerSettings("sac", {"rate": 1e-3, "hidden": [64, 32]})
    name = "smoke-steps900-objectivefitness-trainersac-rate0.001-hidden_64_32"
    assert asked["out"] == Path(f"runs/swimmer-{name}-offline-s5")
    assert "times the human design's efficiency" in said.out
    assert str(asked["out"] / "report.html") in said.out
    assert f"robomore play {asked['out']}" in said.out


def evaluation(status: Status = Status.OK) -> Evaluation:
    design = Design(Morphology(get_task("swimmer").reference), Reward(get_task("swimmer").reward))
    job = Job("swimmer", design, TrainerSettings(), 1_000, 2, 0)
    if status is not Status.OK:
        return Evaluation("key", job, status, "line 3: NameError")
    return Evaluation(
        "key", job, status, fitness=2.0, volume=0.1, efficiency=20.0, episode_fitness=(1.0, 3.0)
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
    assert str(status) in robomore_("evaluate", "swimmer", "--preset", "smoke").out


def test_evaluate_keeps_a_design_that_can_be_named_again(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(robomore.experiment, "evaluate", lambda *_, **__: evaluation())
    out = tmp_path / "mine"
    assert robomore_("evaluate", "swimmer", "--out", out).status == 0
    data = robomore_("inspect", "swimmer", "--parameters", out / "design.json", "--json").json
    assert list(data["parameters"].values()) == list(get_task("swimmer").reference)
    assert "is not empty" in robomore_("evaluate", "swimmer", "--out", out).err


# Errors -------------------------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path: Path, finished: Path) -> dict[str, Path]:
    """Files and folders that something is wrong with."""
    made = {
        "FINISHED": finished,
        "SHORT": tmp_path / "short.json",
        "LARGE": tmp_path / "large.json",
        "BROKEN": tmp_path / "broken.json",
        "WORDS": tmp_path / "words.json",
        "BINARY": tmp_path / "binary.json",
        "TYPO": tmp_path / "typo.json",
        "BADREWARD": tmp_path / "bad.py",
        "EMPTY": tmp_path / "empty",
        "MISSING": tmp_path / "missing",
        "BEHINDFILE": tmp_path / "short.json" / "run",
        "NOPOLICY": tmp_path / "nopolicy",
    }
    made["SHORT"].write_text("[1, 2]")
    made["LARGE"].write_text("[99, 1, 1, 0.1, 0.1, 0.1]")
    made["BROKEN"].write_text("[1, 2")
    made["WORDS"].write_text('["a", "b", "c", "d", "e", "f"]')
    made["BINARY"].write_bytes(b"\xff\xfe\x00")
    made["TYPO"].write_text('{"front_lenght": 1}')
    made["BADREWARD"].write_text("def _get_rew(self, x_velocity, action)\n    return 1")
    made["EMPTY"].mkdir()
    made["NOPOLICY"].mkdir()
    (made["NOPOLICY"] / "design.json").write_bytes(
        (finished / "champion" / "design.json").read_bytes()
    )
    return made


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("run nope", "no task is called 'nope'"),
        ("inspect swimer", "Did you mean 'swimmer'?"),
        ("run swimmer --preset fast", "choose one of smoke, quick"),
        ("run swimmer --preset smoke --designer nobody", "nobody"),
        ("run swimmer --workers 0", "--workers is 0"),
        ("run swimmer --final-steps 0", "--final-steps is 0"),
        ("run swimmer --objective speed", "efficiency"),
        ("run swimmer --trainer ppo", "choose one of crossq, sac, sb3"),
        ("run swimmer --trainer-option hidden", "batch_size=512, for example"),
        ("run swimmer --trainer sac --trainer-option hiden=[8]", "no option 'hiden'; it takes"),
        ("run swimmer --trainer-option batch_size=many", "batch_size"),
        ("run swimmer --preset smoke --trainer sac", "learns nothing in 2048 steps"),
        ("run swimmer --preset smoke --out BEHINDFILE", "--out"),
        ("run ant --preset smoke --out FINISHED", "'swimmer' there and 'ant' here"),
        ("inspect swimmer --parameters SHORT", "2 parameters given, it takes 6"),
        ("inspect swimmer --parameters LARGE", "front_length = 99 m is outside"),
        ("inspect swimmer --parameters BROKEN", "is not JSON"),
        ("inspect swimmer --parameters WORDS", '"a" is not a number'),
        ("inspect swimmer --parameters TYPO", "unknown 'front_lenght'"),
        ("inspect swimmer --parameters BINARY", "not a text file"),
        ("inspect swimmer --parameters MISSING", "cannot be read"),
        ("inspect swimmer --picture EMPTY/a.bmp", "end it in .svg or .png"),
        ("evaluate swimmer --parameters LARGE", "front_length = 99 m is outside"),
        ("evaluate swimmer --reward BADREWARD", "line 1: does not parse"),
        ("evaluate swimmer --reward EMPTY", "cannot be read"),
        ("evaluate swimmer --steps 0", "--steps is 0"),
        ("evaluate swimmer --trainer ppo", "choose one of crossq, sac, sb3"),
        ("evaluate swimmer --trainer-option batch_size=0", "batch_size"),
        ("evaluate swimmer --steps 300", "learns nothing in 300 steps"),
        ("evaluate swimmer --out FINISHED", "is not empty"),
        ("evaluate swimmer --out BEHINDFILE", "cannot write to"),
        ("show EMPTY", "not a run folder"),
        ("report MISSING", "not a run folder"),
        ("report FINISHED --out EMPTY/no/page.html", "cannot write"),
        ("play EMPTY", "neither a run folder nor a design"),
        ("play NOPOLICY", "train it: robomore evaluate swimmer"),
        ("play FINISHED --out a.avi", "end it in .mp4, .webp or .gif"),
        ("run", "TASK"),
        ("run swimmer --seed x", "--seed"),
        ("run swimmer --nonsense", "--nonsense"),
        ("rnu swimmer", "rnu"),
    ],
)
def test_every_mistake_is_one_line_and_status_2(
    robomore_: Command,
    files: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, path in files.items():
        command = command.replace(name, str(path))
    said = robomore_(*command.split())
    assert expected in said.err
    assert said.err.startswith("robomore: ")
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert said.status == 2
    assert not (tmp_path / "runs").exists()


HIDDEN = ImportError("initialization failed")
HIDDEN.__cause__ = KeyboardInterrupt()


@pytest.mark.parametrize(
    ("error", "status", "expected"),
    [
        (HIDDEN, 130, "stopped"),
        (Interrupted("stopped; 3 evaluations are kept"), 130, "3 evaluations are kept"),
        (KeyboardInterrupt(), 130, "stopped"),
        (NothingTrained("all 4 candidates failed"), 1, "all 4 candidates failed"),
        (OSError(28, "No space left on device"), 1, "No space left"),
        (ZeroDivisionError("division\nby zero"), 1, "--debug"),
    ],
)
def test_how_work_that_fails_ends(
    robomore_: Command,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    error: BaseException,
    status: int,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)

    def run(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr(robomore.experiment, "run", run)
    said = robomore_("run", "swimmer")
    assert said.status == status
    assert expected in said.err
    assert said.err.count("\n") == 1
    assert "Traceback" in robomore_("run", "swimmer", "--debug").err


def test_sigterm_is_ctrl_c(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGTERM)

    def run(*_: Any, **__: Any) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(robomore.experiment, "run", run)
    assert robomore_("run", "swimmer").status == 130
    assert signal.getsignal(signal.SIGTERM) is before


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys; from robomore.cli import main; status = main(['--help']);"
        "heavy = {'mujoco', 'numpy', 'jax', 'gymnasium', 'matplotlib'} & set(sys.modules);"
        "sys.exit(f'loaded {heavy}' if heavy else status)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "inspect" in done.stdout
