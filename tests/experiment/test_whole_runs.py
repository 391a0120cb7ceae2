"""Whole runs on a real robot: same seed, same result, however many workers and interruptions."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import msgspec
import pytest

from exhaustive import more_of
from faults.quick_run import SMOKE, command, ended, environment
from faults.run_state import rows
from robomore.errors import RunFolderError
from robomore.experiment import evaluate, run
from robomore.settings import PRESETS, preset, with_method
from robomore.store import Ledger, RunFolder
from robomore.tasks import get_task
from robomore.training.settings import settings_from
from robomore.types import Evaluation
from tiny import TINY, numbers

METHODS = {"robomore": (1, 4), "random": (1, 3), "reference": (0,)}
"""Method -> how many evaluations are kept when its run is killed, once or twice."""


def test_a_run_ends_with_a_champion_and_its_files(trained_run: Path) -> None:
    folder = RunFolder.existing(trained_run)
    for name in ("design.json", "reward.py", "robot.xml", "policy.npz"):
        assert (folder.champion / name).is_file(), name
    assert not list(folder.scratch.glob("*"))
    design = msgspec.json.decode((folder.champion / "design.json").read_bytes())
    get_task("swimmer").check(design["parameters"])
    stages = [place.stage for place, _ in Ledger(folder.ledger, read_only=True).placed()]
    assert stages == ["coarse"] * 2 + ["fine"] * 2 + ["final"] * 4


@pytest.mark.parametrize("method", more_of(METHODS, "robomore"))
def test_one_worker_gives_the_same_numbers_as_two_and_so_does_a_run_that_was_killed(
    method: str, tmp_path: Path
) -> None:
    """Over the command line, with real worker processes; only the numbers are made up."""
    words = (*SMOKE, "--method", method)
    for workers in ("1", "2"):
        done = ended(*words, "--workers", workers, "--out", tmp_path / workers)
        assert done.returncode == 0, done.stderr
    assert numbers(tmp_path / "1") == numbers(tmp_path / "2")
    out = tmp_path / "killed"
    for kept in METHODS[method]:
        killed = command(*words, "--workers", "2", "--out", out, work="slow")
        process = subprocess.Popen(killed, env=environment(), start_new_session=True)
        _wait(lambda kept=kept: (out / "run.json").exists() and len(rows(out)) >= kept, process)
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert len(rows(out)) < len({key for _, key, *_ in numbers(tmp_path / "2")}), "killed too late"
    done = ended(*words, "--workers", "2", "--out", out)
    assert done.returncode == 0, done.stderr
    assert numbers(out) == numbers(tmp_path / "2")


@pytest.mark.exhaustive  # The same, but trained; the rest of a run is the same for any method.
@pytest.mark.parametrize("method", METHODS)
def test_any_method_trains_the_same_with_one_worker_as_with_two(
    method: str, tmp_path: Path
) -> None:
    settings = with_method(TINY, method)
    for workers in (1, 2):
        run("swimmer", settings, seed=1, workers=workers, out=tmp_path / str(workers))
    assert numbers(tmp_path / "1") == numbers(tmp_path / "2")


def test_another_seed_gives_other_numbers() -> None:
    ours, other = (evaluate("swimmer", settings=TINY, steps=512, seed=seed) for seed in (1, 2))
    assert ours.fitness != other.fitness


def test_a_finished_run_recomputes_nothing(trained_run: Path) -> None:
    before = numbers(trained_run)
    began = time.monotonic()
    result = run("swimmer", TINY, seed=1, out=trained_run)
    # Eight trainings take many times as long.
    assert time.monotonic() - began < 10
    assert numbers(trained_run) == before
    assert result.champion is not None
    assert all(evaluation.ok for evaluation in result.champion.evaluations)


@pytest.mark.exhaustive  # tests/faults/test_kills.py does the same with a quick trainer
def test_a_run_killed_again_and_again_ends_as_an_uninterrupted_one(
    trained_run: Path, tmp_path: Path
) -> None:
    program = textwrap.dedent(
        """
        import sys, msgspec
        from robomore.experiment import run
        from robomore.settings import RunSettings
        settings = msgspec.json.decode(sys.argv[1], type=RunSettings)
        run("swimmer", settings, seed=1, workers=2, out=sys.argv[2])
        """
    )
    out = tmp_path / "killed"
    command = [sys.executable, "-c", program, msgspec.json.encode(asdict(TINY)).decode(), str(out)]
    for seconds in (3.0, 6.0, 9.0):
        process = subprocess.Popen(command, start_new_session=True)
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        process.wait()
    subprocess.run(command, check=True, timeout=300)
    assert numbers(out) == numbers(trained_run)
    assert not _still_running(out), "a worker outlived its run"


def test_a_folder_of_another_run_is_refused_before_anything_starts(trained_run: Path) -> None:
    with pytest.raises(RunFolderError, match="task is 'swimmer' there and 'ant' here"):
        run("ant", TINY, seed=1, out=trained_run)


def test_two_rewards_lead_to_two_policies() -> None:
    """A reward that never reaches training would give the same policy as any other."""
    lively, lazy = (
        evaluate("swimmer", reward=_effort(target), settings=TINY, steps=6_144, seed=0)
        for target in (0.9, 0.0)
    )
    assert lively.ok and lazy.ok
    assert lively.fitness != lazy.fitness
    # Each has learnt what its own reward pays for.
    assert lively.behaviour["mean_effort"] > 0.6
    assert lazy.behaviour["mean_effort"] < 0.2


def test_the_same_evaluation_twice_is_the_same_to_the_last_digit() -> None:
    first, second = (evaluate("hopper", settings=TINY, steps=600, seed=5) for _ in range(2))
    assert _timeless(first) == _timeless(second)
    assert (first.job.steps, first.steps) == (600, 512), "whole rounds were done"


def test_a_checkpoint_continues_as_if_it_had_never_stopped(tmp_path: Path) -> None:
    whole = evaluate("swimmer", settings=TINY, steps=768, seed=0)
    evaluate("swimmer", settings=TINY, steps=512, seed=0, checkpoint=tmp_path)
    continued = evaluate("swimmer", settings=TINY, steps=768, seed=0, checkpoint=tmp_path)
    assert _timeless(continued) == _timeless(whole)


def test_a_checkpoint_is_never_continued_by_another_design(tmp_path: Path) -> None:
    evaluate("swimmer", reward=_effort(0.9), settings=TINY, steps=512, checkpoint=tmp_path)
    thin = [1, 1, 1, 0.05, 0.05, 0.05]
    for other in ({"reward": _effort(0.0)}, {"reward": _effort(0.9), "parameters": thin}):
        alone = evaluate("swimmer", settings=TINY, steps=512, **other)
        beside = evaluate("swimmer", settings=TINY, steps=512, checkpoint=tmp_path, **other)
        assert _timeless(beside) == _timeless(alone)
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize(
    ("reward", "status", "said"),
    [
        (
            "def _get_rew(self, x_velocity, action):\n    return 1 / 0, {}",
            "reward-failed",
            "line 2",
        ),
        ("def _get_rew(self, x_velocity, action)\n    return 1, {}", "invalid-reward", "line 1"),
        (
            "def _get_rew(self, x_velocity, action):\n    return float('nan'), {}",
            "reward-failed",
            "nan",
        ),
    ],
)
def test_a_failure_is_a_status_with_a_diagnosis(reward: str, status: str, said: str) -> None:
    evaluation = evaluate("swimmer", reward=reward, settings=TINY)
    assert (evaluation.status, evaluation.fitness, evaluation.efficiency) == (status, None, None)
    assert said in evaluation.diagnosis


def test_presets_are_known_by_name_and_grow() -> None:
    steps = [preset(name).candidate.steps for name in ("smoke", "quick", "standard", "paper")]
    assert steps == sorted(steps)


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_names_a_trainer_that_there_is(name: str) -> None:
    settings = preset(name)
    rounds = settings_from(settings.trainer)
    assert settings.candidate.steps > rounds.learning_starts + rounds.train_freq


def _wait(until: Callable[[], bool], process: subprocess.Popen[bytes]) -> None:
    began = time.monotonic()
    while not until():
        assert process.poll() is None, "it ended before it was killed"
        assert time.monotonic() - began < 120, "it does not get that far"
        time.sleep(0.02)


def _effort(target: float) -> str:
    return (
        "def _get_rew(self, x_velocity, action):\n"
        f"    return -np.sum((action - {target}) ** 2), {{}}\n"
    )


def _timeless(evaluation: Evaluation) -> dict[str, object]:
    """All of an evaluation but what the clock says."""
    return {**asdict(evaluation), "seconds": None}


def _still_running(out: Path) -> bool:
    """Whether any process was started for this run folder and lives."""
    time.sleep(1.0)
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if str((process / "cwd").readlink()).startswith(str(out)):
                return True
        except OSError:
            continue
    return False
