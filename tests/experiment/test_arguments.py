"""Arguments of `robomore.run` that are refused before anything starts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robomore.errors import InputError
from robomore.experiment import evaluate, run
from robomore.experiment.arguments import ensure_usable, warn_of_size
from robomore.experiment.first_look import refuse_untrained
from robomore.options import with_options
from robomore.search import SearchContext, make_method
from robomore.settings import preset
from robomore.tasks import get_task
from robomore.types import Design, MethodSettings, Morphology, Reward
from search.fakes import context_of

SMOKE = preset("smoke")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"seed": "1"}, "the seed is '1'; give a whole number from 0 up"),
        ({"seed": -1}, "the seed is -1"),
        ({"seed": True}, "the seed is True"),
        ({"workers": 0}, "the number of workers is 0; give a whole number from 1 up"),
        ({"workers": 1.5}, "the number of workers is 1.5"),
        ({"budget_steps": "many"}, "the budget in control steps is 'many'"),
        ({"time_limit": "30m"}, "the time limit is '30m'; give a positive number, in s"),
        ({"time_limit": float("nan")}, "the time limit is nan"),
        ({"time_limit": 0}, "the time limit is 0"),
        ({"out": 5}, "the run's folder is 5"),
    ],
)
def test_a_wrong_kind_is_refused(wrong: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as raised:
        run("swimmer", "smoke", **({"out": tmp_path / "run"} | wrong))
    assert said in str(raised.value)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"objective": "eficiency"}, "the objective is 'eficiency'; choose efficiency, fitness"),
        ({"final": replace(SMOKE.final, seeds=0)}, "final.seeds is 0; give a whole number from 1"),
        ({"final": replace(SMOKE.final, finalists=0)}, "final.finalists is 0"),
        ({"candidate": replace(SMOKE.candidate, episodes=0)}, "candidate.episodes is 0"),
        ({"evaluations": 2.5}, "evaluations is 2.5"),
    ],
)
def test_settings_of_one_s_own_are_checked_before_the_search(
    changed: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as raised:
        run("swimmer", replace(SMOKE, **changed), out=tmp_path / "run")
    assert said in str(raised.value)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("options", [{"n_critics": 1}, {"normalize_rewards": False}])
def test_options_that_clash_with_tuned_ones_are_refused_before_anything_starts(
    options: dict[str, Any], tmp_path: Path
) -> None:
    settings = with_options(SMOKE, method="random", trainer_options=options)
    with pytest.raises(InputError, match="is tuned for ant, not given"):
        run("ant", settings, out=tmp_path / "run")
    with pytest.raises(InputError, match="is tuned for ant, not given"):
        evaluate("ant", settings=settings)
    assert not (tmp_path / "run").exists()


def test_a_first_look_at_what_has_learnt_nothing_is_refused(tmp_path: Path) -> None:
    screened = with_options(SMOKE, method_options={"screening": "halving"})
    with pytest.raises(InputError) as raised:
        run("swimmer", screened, executor="inline", out=tmp_path / "run")
    assert str(raised.value) == (
        "the stage coarse cuts designs after 410 of 2048 steps, and trainer crossq has learnt "
        "nothing before 512; give at least --steps 2561, let it learn sooner with "
        "--trainer-option learning_starts=NUMBER, or train all designs to the end "
        "(--method-option screening=none)"
    )
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("options", "refused"),
    [
        ({"screening": "halving"}, True),
        ({"screening": "none"}, False),
        ({"screening": "halving", "rungs": []}, False),
        ({"screening": "halving", "without": ["coarse"]}, False),
        ({"screening": "halving", "rungs": [{"budget_fraction": 0.25, "keep_fraction": 1}]}, False),
    ],
)
def test_the_first_look_is_that_of_the_plan(options: dict[str, Any], refused: bool) -> None:
    settings = with_options(SMOKE, method_options=options)
    task = get_task("swimmer")
    context = SearchContext(
        task=task,
        reference=Design(Morphology(task.reference), Reward(task.reward)),
        candidate=settings.candidate,
        evaluations=4,
    )
    plan = make_method(settings.method).plan(context)
    if not refused:
        refuse_untrained(task, settings, plan)
        return
    with pytest.raises(InputError, match="cuts designs after 410"):
        refuse_untrained(task, settings, plan)


def test_no_steps_are_not_the_preset_s() -> None:
    with pytest.raises(InputError, match="the number of steps is 0"):
        evaluate("swimmer", settings="smoke", steps=0)


def test_numbers_of_numpy_are_numbers() -> None:
    ensure_usable(np.int64(3), np.int32(2), np.int64(10), np.float64(0.5), "runs/one")


@pytest.mark.parametrize(
    ("method", "options", "trainings", "warned"),
    [
        # `standard` has 72 evaluations.
        ("bayesian", {}, 20, True),
        ("map-elites", {}, 200, True),
        ("cmaes", {}, 72, False),
        ("random", {}, 60, False),
        ("eureka", {}, 20, True),
        ("robomore", {}, 20, False),
        ("genetic", {"evaluations": 30}, 20, False),
    ],
)
def test_a_method_that_is_sized_for_another_budget_is_told(
    method: str,
    options: dict[str, Any],
    trainings: int,
    warned: bool,
    caplog: pytest.LogCaptureFixture,
) -> None:
    context = context_of("swimmer", 72)
    made = make_method(MethodSettings(method, options))
    warn_of_size(made, context, trainings * context.candidate.steps)
    assert bool(caplog.records) == warned
    if warned:
        said = caplog.text
        assert f"pays for {trainings} full trainings" in said and "sized for 7" in said
        caplog.clear()
        sized = replace(context, evaluations=trainings)
        warn_of_size(made, sized, trainings * context.candidate.steps)
        assert f"--evaluations {trainings} beside" in said and not caplog.records
    warn_of_size(made, context, None)
