"""A reward is tried out before it is trained under: what is found, in words a model can act on."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from robomore.errors import RewardFailed
from robomore.rewards import dry_run
from robomore.rewards.dry_run import (
    NUM_ENVS,
    RANDOM_MORPHOLOGIES,
    STEPS,
    DryRun,
    DryRunRequest,
    observe,
)
from robomore.rewards.dry_run_findings import Observed, Term, findings, morphologies
from robomore.tasks import TASKS, get_task

PLAIN = {"speed": Term(1.0, 0, 0.0, -2.0, 3.0), "effort": Term(0.5, 0, -1.0, -2.0, 0.0)}
SPEED = Term(0.5, 0, 0.0, -1.0, 1.0)


SOURCE = """
def _get_rew(self, x_velocity, action):
    terms = {"speed": x_velocity, "effort": 0.0}
    terms["healthy"] = 1.0
    return sum(terms.values()), terms
"""


def observed(**changes: object) -> Observed:
    usual = {"calls": 300, "low": -1.0, "high": 2.0, "seconds": 2e-5, "terms": PLAIN}
    return Observed(**{**usual, **changes})  # type: ignore[arg-type]


def program(*lines: str) -> str:
    return "\n".join(("def _get_rew(self, x_velocity, action):", *(f"    {x}" for x in lines), ""))


def test_a_usual_reward_gives_no_findings() -> None:
    assert findings(observed(), SOURCE) == []


def test_a_bonus_that_never_changes_is_noted_and_no_rival() -> None:
    bonus = {"speed": PLAIN["speed"], "healthy": Term(0.0, 0, 1.0, 1.0, 1.0)}
    (found,) = findings(observed(terms=bonus), SOURCE)
    assert (found.line, found.severity) == (4, "note")
    assert "'healthy' was the same number in all 300 steps" in found.message


@pytest.mark.parametrize(
    ("changes", "severity", "said"),
    [
        ({"low": 1.0, "high": 1.0}, "error", "same number (1) in all 300 steps"),
        ({"seconds": 0.02}, "error", "one call takes 20.0 ms"),
        ({"seconds": 0.002}, "warning", "one call takes 2.0 ms"),
        ({"terms": {}}, "warning", "no terms"),
        (
            {"terms": {**PLAIN, "odd": Term(0.1, 3, 0.0, 0.0, 1.0)}},
            "warning",
            "'odd' was not always a finite",
        ),
        (
            {"terms": {**PLAIN, "spin": Term(), "drift": Term()}},
            "warning",
            "'spin', 'drift' were 0 in all 300 steps",
        ),
        (
            {"low": -3e179, "terms": {**PLAIN, "far": Term(1e178, 0, 0.0, -3e179, 1.0)}},
            "error",
            "the reward was -3e+179 (its largest term: 'far', -3e+179), which is too large",
        ),
        ({"low": 0.0, "high": 1e-120}, "error", "1e-120 (its largest term: 'speed', 3) at most"),
        (
            {"low": 1e12, "high": 1e12 + 1},
            "error",
            "and differed by only 1 in 300 steps: too few digits",
        ),
        (
            {"high": 1e80, "usual": 0.3, "terms": {**PLAIN, "e": Term(1e3, 0, 0.0, 0.0, 1e80)}},
            "warning",
            "1e+80 (its largest term: 'e', 1e+80) in one state and 0.3 in a usual one",
        ),
        (
            {"terms": {"effort": Term(400.0, 0, -900.0, -2e3, -1.0), "speed": SPEED}},
            "warning",
            "'effort' dominates: under random actions it varies 800 times as much as 'speed'",
        ),
    ],
)
def test_what_is_found(changes: dict[str, object], severity: str, said: str) -> None:
    found, *_ = findings(observed(**changes), SOURCE)
    assert (found.line, found.severity) == (3 if "dominates" in said else 2, severity)
    assert said in found.message


@pytest.mark.parametrize("task", [get_task(name) for name in TASKS], ids=list(TASKS))
def test_morphologies_are_valid_and_the_same_every_time(task) -> None:
    first = morphologies(task, RANDOM_MORPHOLOGIES)
    assert first == morphologies(task, RANDOM_MORPHOLOGIES)
    assert len(set(first)) == RANDOM_MORPHOLOGIES + 1 and first[-1] == task.reference
    assert all(task.check(parameters) for parameters in first)


@pytest.mark.parametrize(
    ("large", "small", "told"),
    [
        ("speed", Term(1e-4, 0, -3e-4, -1e-3, 0.0), False),  # a cost of control
        ("speed", Term(1e-4, 0, 9e-4, 0.0, 1e-3), False),  # a bonus, mostly paid
        ("speed", Term(4e-4, 0, 2e-4, 0.0, 1e-3), False),  # a bonus, seldom paid
        ("speed", Term(2e-4, 0, 1e-4, 0.0, 1e-3), True),  # forward motion alone, clipped at 0
        ("speed", Term(1e-4, 0, 0.0, -1e-3, 1e-3), True),
        ("effort", Term(1e-4, 0, 0.0, -1e-3, 1e-3), True),
        ("healthy", Term(1e-4, 0, 0.0, -1e-3, 1e-3), True),
        ("effort", Term(1e-4, 0, -3e-4, -1e-3, 0.0), False),
    ],
)
def test_a_term_may_drown_a_cost_or_a_bonus_and_no_drive(
    large: str, small: Term, told: bool
) -> None:
    above = {
        "speed": SPEED,
        "effort": Term(0.5, 0, -0.9, -2.0, -0.1),
        "healthy": Term(0.4, 0, 0.8, 0.0, 1.0),
    }
    found = findings(observed(terms={large: above[large], "other": small}), SOURCE)
    assert [f"{large!r} dominates" in it.message for it in found] == [True] * told


@pytest.mark.parametrize("name", list(TASKS))
def test_the_reference_reward_costs_no_request(name: str, tmp_path: Path) -> None:
    task = get_task(name)
    found = DryRun(task, tmp_path)(task.reward)
    assert [f for f in found if f.severity != "note"] == []
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("lines", "line", "said"),
    [
        (["speed = x_velocity", "return self.no_such_thing, {}"], 3, "no_such_thing"),
        (["while True:", "    pass"], 3, "did not return within 1 s"),
        (["import os", "os._exit(0)"], 1, "when tried out"),
    ],
)
def test_a_bad_reward_is_told_of_in_its_line(
    lines: list[str], line: int, said: str, tmp_path: Path
) -> None:
    found, *_ = DryRun(get_task("swimmer"), tmp_path)(program(*lines))
    assert found.severity == "error" and said in found.message
    if "while" not in lines[0]:
        assert found.line == line


def test_terms_that_do_not_add_up_are_noted_and_not_refused(tmp_path: Path) -> None:
    source = program(
        "effort = float(np.sum(action ** 2))",
        "return x_velocity - 0.1 * effort, {'speed': x_velocity, 'effort': effort}",
    )
    (found,) = DryRun(get_task("swimmer"), tmp_path)(source)
    assert (found.severity, found.line) == ("note", 1)
    assert re.search(
        r"do not add up to the reward in \d+ of 600 calls: \S+ and \S+ in", found.message
    )


def test_terms_that_add_up_but_for_rounding_do() -> None:
    lines = (
        "speed = np.float32(x_velocity)",
        "effort = np.float32(0.1 * np.sum(action ** 2))",
        "return float(speed) - 0.1 * float(np.sum(action ** 2)), {'speed': speed, 'c': -effort}",
    )
    assert tried(program(*lines)).apart is None


def test_every_call_of_a_good_reward_is_seen(tmp_path: Path) -> None:
    source = program(
        "speed = 1000 * float(x_velocity)",
        "effort = 0.1 * float(np.sum(action ** 2))",
        "return speed - effort, {'speed': speed, 'effort': -effort}",
    )
    assert DryRun(get_task("swimmer"), tmp_path)(source.replace("1000", "1")) == []
    (found,) = DryRun(get_task("swimmer"), tmp_path)(source.replace("0.1", "1e5"))
    assert found.severity == "warning" and "'effort' dominates" in found.message


def tried(source: str) -> Observed:
    """Return what a dry run observes, in this process."""
    task = get_task("swimmer")
    request = DryRunRequest(task.id, (task.reference,), source)
    reply = observe(msgspec.json.encode(request), Path(), lambda done: None)
    return msgspec.json.decode(reply, type=Observed)


@pytest.mark.filterwarnings("ignore:.*encountered in (log|exp)")
@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["return self.data.xpos[self.torso_id][0], {}"], "torso_id"),
        (["return self.data.qpos[22], {}"], "index 22 is out of bounds"),
        (["x = math.log(x_velocity)", "return x, {'x': x}"], "math domain error (line 2"),
        (["x = float(np.log(x_velocity))", "return x, {'x': x}"], "nan (the term 'x' was nan)"),
        (["x = float(np.exp(1e4 * x_velocity))", "return x, {'x': x}"], "'x' was inf"),
        (["return x_velocity"], "must return (reward, terms)"),
        (["return np.array([1.0, 2.0]), {}"], "an array of shape (2,)"),
        (["return x_velocity, {'a\\nb': x_velocity}"], "'a\\nb' is no name of a term"),
        (["return x_velocity, {'a\\x1b[2J': x_velocity}"], "is no name of a term"),
        (["return x_velocity - self.data.energy[1], {}"], "cannot read `energy`"),
        (["return self.action_space.sample()[0], {}"], "no attribute 'sample'"),
        (["self.metadata['x'] = 1", "return x_velocity, {}"], "does not support item assignment"),
    ],
)
def test_what_only_a_try_shows(lines: list[str], said: str) -> None:
    with pytest.raises(RewardFailed) as failed:
        tried(program(*lines))
    assert said in str(failed.value)


def test_terms_of_any_finite_size_have_statistics() -> None:
    observed = tried(program("return x_velocity, {'v': x_velocity, 'huge': 1e307 * x_velocity}"))
    term = observed.terms["huge"]
    assert np.isfinite([term.spread, term.mean, term.low, term.high]).all() and term.spread > 1e305
    assert observed.calls == NUM_ENVS * STEPS


@pytest.mark.parametrize("scale", ["1e120", "1e-120", "1e300"])
def test_a_size_that_makes_no_sense_is_an_error_with_term_and_value(scale: str) -> None:
    seen = tried(program(f"x = {scale} * x_velocity", "return x, {'x': x, 'v': x_velocity}"))
    found, *_ = findings(seen, SOURCE)
    term, value = ("'v'", "e-") if scale == "1e-120" else ("'x'", scale[1:].replace("e", "e+"))
    assert found.severity == "error" and term in found.message and value in found.message


@pytest.mark.parametrize("scale", ["1e80", "1e-12", "1e12"])
def test_a_size_that_training_normalises_is_no_fault(scale: str) -> None:
    seen = tried(program(f"x = {scale} * x_velocity", "return x, {'x': x}"))
    assert findings(seen, SOURCE) == []


def test_a_constant_reward_is_an_error() -> None:
    found, *_ = findings(tried(program("return 1.0, {'alive': 1.0}")), SOURCE)
    assert found.severity == "error"
    assert f"same number (1) in all {NUM_ENVS * STEPS} steps" in found.message


def test_a_slow_reward_is_not_tried_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dry_run, "_MOST_SECONDS", 0.1)
    monkeypatch.setattr(dry_run, "check_continuation", lambda *given: pytest.fail("tried further"))
    slow = program("x = sum(range(2_000_000)) * 0.0 + x_velocity", "return x, {'forward': x}")
    seen = tried(slow)
    assert 0 < seen.calls < NUM_ENVS * STEPS / 2
    found, *_ = findings(seen, SOURCE)
    assert found.severity == "error" and "one call takes" in found.message


def test_each_simulation_has_a_reward_of_its_own() -> None:
    seen = tried("N = []\n" + program("N.append(1)", "return x_velocity, {'n': len(N)}"))
    assert seen.terms["n"].high == STEPS


@pytest.mark.parametrize(
    ("written", "meant"),
    [("np.sqare(action)", "square"), ("math.sqart(2)", "sqrt"), ("abs(acton)", "action")],
)
def test_a_misspelt_name_comes_with_the_one_that_was_meant(
    written: str, meant: str, tmp_path: Path
) -> None:
    task = get_task("swimmer")
    source = "import math\n" + program(f"return float(np.sum({written})), {{}}")
    request = DryRunRequest(task.id, (task.reference,), source)
    with pytest.raises(RewardFailed, match=f"Did you mean '{meant}'"):
        observe(msgspec.json.encode(request), tmp_path, lambda done: None)
