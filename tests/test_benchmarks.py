"""Benchmarks run, at sizes that measure nothing; what they found in earnest is in the documents."""

from __future__ import annotations

import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from robomore.tasks import get_task
from robomore.training.settings import CrossQSettings, settings_from
from robomore.training.tuned import resolve
from robomore.types import TrainerSettings

ROOT = Path(__file__).parents[1]


def run(arguments: str) -> str:
    """Run a benchmark and return what it prints."""
    name, *rest = shlex.split(arguments)
    command = [sys.executable, ROOT / "benchmarks" / name, *rest]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        pytest.param(
            "update.py --net-arch 16 16 --batch-size 16 --seconds 0.1",
            ["bare matrix products", "RoboMoRe"],
            marks=pytest.mark.exhaustive,
        ),
        ("orchestration.py cost --evaluations 40", ["40 evaluations", "MiB", "the live view"]),
        pytest.param(
            "orchestration.py standard --preset smoke",
            ["1 runs", "longest chain", "1024"],
            marks=pytest.mark.exhaustive,
        ),
        pytest.param(
            "integrators.py --robots swimmer --steps 6400",
            ["swimmer, seed 0, 6400 steps", "RK4", "IMPLICITFAST"],
            marks=pytest.mark.exhaustive,
        ),
        (
            "simulation.py --steps 4 --replace-rk4",
            ["ant", "half-cheetah", "hopper", "walker", "swimmer"],
        ),
        pytest.param(
            "learning.py --robots swimmer --seeds 1 --steps 6400 --every 3200 "
            "--set learning_starts=1024",
            ["swimmer, human morphology", "3200", "6400"],
            marks=pytest.mark.exhaustive,
        ),
    ],
)
def test_a_benchmark_prints_its_table(arguments: str, told: list[str]) -> None:
    printed = run(arguments)
    assert [word for word in told if word not in printed] == []


@pytest.mark.parametrize("robot", ["ant", "half-cheetah", "hopper", "walker", "swimmer"])
def test_what_is_compared_with_sbx_has_its_settings_for_every_robot(
    robot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    from against_sbx import SAME
    from update import settings_like_sbx

    found = settings_from(resolve(TrainerSettings("crossq", SAME), get_task(robot)))
    sizes = {"net_arch": (128, 128), "batch_size": 128}
    plain = {"normalize_rewards": False, "n_steps": 1, "num_bins": 0, "observed": None}
    critics = {"n_critics": 2, "min_q_weight": 1.0}
    usual = {"init_alpha": 1.0, "alpha_lr": 1e-3, "policy_ema_fraction": 0.0}
    alike = CrossQSettings(**sizes, **plain, **critics, **usual, num_eval_checkpoints=1)
    assert found == alike
    assert replace(settings_like_sbx((128, 128), 128), buffer_size=alike.buffer_size) == alike


def test_screening_finds_the_recorded_best_for_a_third_of_the_steps() -> None:
    told = run("screening.py --steps 100000").splitlines()
    line = next(line for line in told if "the default" in line)
    *_, recall, best, worth, share, kept = line.split()
    assert (recall, best, worth, kept) == ("1.00", "6", "1.000", "yes")
    assert float(share) <= 1 / 3


def test_morphologies_first_finds_the_best_of_half_cheetahs_grid_for_less() -> None:
    told = run("morphologies_first.py").splitlines()
    rows = {line[:54].strip(): [float(word) for word in line[54:].split()] for line in told[3:]}
    halving, first, *_ = rows.values()
    assert first[:2] == [1.0, 1.0]
    assert halving[1] < 1.0 and first[2] < halving[2]
