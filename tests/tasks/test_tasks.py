"""The tasks as values: their figures, what they accept and what they say when they refuse."""

from __future__ import annotations

import ast
import math
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from paper import PAPER, PUBLISHED
from robomore.errors import InputError, InvalidMorphology
from robomore.tasks import TASKS, Rule, Task, get_task
from robomore.tasks.registry import PAPER_TASKS
from robomore.tasks.unit_space import UnitSpace

EIGHT = (
    *("ant", "ant-powered", "ant-desert", "ant-jump"),
    *("hopper", "half-cheetah", "swimmer", "walker"),
)


def test_the_eight_tasks_are_there() -> None:
    assert list(TASKS) == [*EIGHT, "crawler"]
    assert all(task.id == id for id, task in TASKS.items())
    assert tuple(PAPER) == EIGHT


def test_reference_body_is_a_valid_one_given_either_way(task: Task) -> None:
    assert task.check(task.reference) == task.reference
    assert task.check(dict(zip(task.names, task.reference, strict=True))) == task.reference


def test_parameters_are_described_and_bounded(task: Task) -> None:
    assert len(set(task.names)) == len(task.names)
    for parameter in task.parameters:
        assert parameter.low < parameter.reference < parameter.high or parameter.reference in (
            parameter.low,
            parameter.high,
        )
        assert parameter.meaning and parameter.unit == "m"
        low, high = parameter.search or (parameter.low, parameter.high)
        assert parameter.low <= low <= parameter.reference <= high <= parameter.high
        assert parameter.scale == "linear" or low > 0


@pytest.mark.parametrize("count", [0, 5, 25])
def test_wrong_count_says_how_many_it_takes(task: Task, count: int) -> None:
    with pytest.raises(InvalidMorphology, match=rf"{count} .* takes {len(task.names)}"):
        task.check([0.1] * count)


def test_out_of_bounds_names_parameter_value_and_bound(task: Task) -> None:
    parameter = task.parameters[0]
    body = dict(zip(task.names, task.reference, strict=True)) | {parameter.name: 17.25}
    with pytest.raises(InvalidMorphology) as refused:
        task.check(body)
    for said in (task.id, parameter.name, "17.25", f"{parameter.low:g}", f"{parameter.high:g}"):
        assert said in str(refused.value)


def test_no_number_is_refused(task: Task) -> None:
    with pytest.raises(InvalidMorphology, match="nan"):
        task.check([math.nan, *task.reference[1:]])
    with pytest.raises(InvalidMorphology, match="not a number"):
        task.check(["wide", *task.reference[1:]])  # type: ignore[list-item]


VIOLATIONS: list[tuple[str, int, dict[str, float], tuple[str, ...]]] = [
    ("ant", 0, {"leg_x": 0.0, "leg_y": 0.0}, ("leg_x = 0 m", "leg segment")),
    ("ant", 1, {"foot_x": 0.01, "foot_y": 0.02}, ("foot_x = 0.01", "foot_y = 0.02", "0.2 m")),
    ("ant", 2, {"torso_radius": 0.48, "foot_x": 0.1}, ("torso_radius = 0.48", "0.4623")),
    ("ant", 3, {"leg_x": 1.5}, ("leg_x = 1.5", "hip_x = 0.2", "0.454")),
    ("hopper", 0, {"knee_height": 1.2}, ("knee_height = 1.2", "hip_height = 1.05")),
    ("hopper", 1, {"foot_back": 0.1, "foot_front": 0.1}, ("foot_front = 0.1", "same point")),
    ("hopper", 2, {"knee_height": 1.02}, ("knee_height = 1.02", "hip_height = 1.05", "0.05")),
    ("hopper", 3, {"foot_back": 0.0, "foot_front": 0.01}, ("foot_front = 0.01", "0.02")),
    ("hopper", 4, {"foot_radius": 0.2}, ("foot_radius = 0.2", "ankle_height = 0.1")),
    ("hopper", 5, {"torso_radius": 0.25, "leg_radius": 0.1, "hip_height": 0.9},
     ("torso_radius", "0.35", "hip_height - knee_height = 0.3")),
    ("walker", 0, {"torso_top": 1.04}, ("torso_top = 1.04", "hip_height = 1.05")),
    ("walker", 1, {"foot_front": 0.0}, ("foot_front = 0", "same point")),
    ("walker", 2, {"torso_top": 1.06}, ("torso_top = 1.06", "hip_height = 1.05", "0.05")),
    ("walker", 3, {"foot_front": 0.01}, ("foot_front = 0.01", "0.02")),
    ("walker", 4, {"leg_radius": 0.15}, ("leg_radius = 0.15", "ankle_height = 0.1")),
    ("swimmer", 0, {"back_radius": 0.012}, ("back_radius = 0.012", "front_length = 1", "0.017")),
    ("half-cheetah", 0, {"head_x": 0.0, "head_z": 0.0}, ("head_x = 0", "1e-06")),
    ("half-cheetah", 1, {"head_x": 0.01, "head_z": 0.0}, ("head_x = 0.01", "0.03")),
    ("half-cheetah", 2, {"front_foot_z": 0.5}, ("front_foot_z", "0.09419", "0 m")),
    ("half-cheetah", 3, {"back_thigh_z": -0.9, "back_shin_z": 0.4},
     ("back_thigh_z = -0.9", "-0.6812")),
    ("half-cheetah", 4, {"back_thigh_z": 0.2, "front_thigh_z": 0.2, "head_radius": 0.2},
     ("head_radius = 0.2", "0.1142")),
]  # fmt: skip


def all_rules(task: Task) -> tuple[Rule, ...]:
    return (*task.rules, *task.search_rules)


@pytest.mark.parametrize(("id", "index", "changes", "said"), VIOLATIONS)
def test_each_rule_names_parameters_values_and_bound(
    id: str, index: int, changes: dict[str, float], said: tuple[str, ...]
) -> None:
    task = get_task(id)
    body = dict(zip(task.names, task.reference, strict=True))
    rule = all_rules(task)[index]
    assert rule.violation(body) is None
    fault = rule.violation(body | changes)
    assert fault is not None
    for words in said:
        assert words in fault
    with pytest.raises(InvalidMorphology):
        task.searched().check(body | changes)
    if rule in task.search_rules:
        assert task.check(body | changes), "a rule for samplers refuses nobody else's morphology"
    else:
        with pytest.raises(InvalidMorphology):
            task.check(body | changes)


def test_every_rule_is_tried_above() -> None:
    tried = {(id, index) for id, index, _, _ in VIOLATIONS}
    families = {task.id: task for task in PAPER_TASKS if not task.id.startswith("ant-")}
    assert tried == {(id, i) for id, task in families.items() for i in range(len(all_rules(task)))}
    assert all(all_rules(TASKS[id]) == all_rules(TASKS["ant"]) for id in TASKS if "ant-" in id)


@pytest.mark.parametrize("id", PUBLISHED)
def test_every_published_morphology_is_accepted(id: str) -> None:
    task = get_task(id)
    for row in PUBLISHED[id]:
        assert task.check(row) == tuple(row)
        assert task.volume(row) > 0
    assert len(PUBLISHED[id]) == 15


@pytest.mark.parametrize("id", ["hopper", "walker"])
def test_the_order_of_a_foot_s_ends_is_free(id: str) -> None:
    task = get_task(id)
    body = dict(zip(task.names, task.reference, strict=True))
    turned = body | {"foot_back": body["foot_front"], "foot_front": body["foot_back"]}
    assert task.volume(turned) == task.volume(body)
    both_behind = body | {"foot_back": -0.05, "foot_front": -0.3}
    assert task.check(both_behind)


def test_samplers_keep_to_their_own_ranges() -> None:
    task = get_task("half-cheetah")
    searched = task.searched()
    assert searched.searched() == searched
    long = dict(zip(task.names, task.reference, strict=True)) | {"back_foot_z": -2.5}
    assert task.check(long)
    with pytest.raises(InvalidMorphology, match=r"back_foot_z = -2.5 m is outside \[-1, 0.5\]"):
        searched.check(long)
    space = UnitSpace(task)
    assert space.units([list(long.values())]).min() == 0.0, "it counts as the nearest one within"
    assert space.volumes(np.array([list(long.values())]))[0] == task.volume(long)
    assert not space.valid(np.array([list(long.values())]))[0]


def test_rewards_are_the_official_formulas(task: Task) -> None:
    speed, height_rate, action = 1.7, -0.4, np.array([0.5, -1.0])
    robot: Any = SimpleNamespace(
        _forward_reward_weight=1.25,
        healthy_reward=0.8,
        contact_cost=0.03,
        control_cost=lambda given: 0.5 * np.sum(np.square(given)),
        data=SimpleNamespace(qvel=np.array([9.0, 9.0, height_rate])),
    )
    space: dict[str, Any] = {}
    exec(task.reward, space)
    reward, terms = space["_get_rew"](robot, speed, action)
    expected = 1.25 * (height_rate if task.id == "ant-jump" else speed) - 0.625
    if task.id not in ("swimmer", "half-cheetah"):
        expected += 0.8
    if task.id.startswith("ant"):
        expected -= 0.03
    assert reward == pytest.approx(expected, abs=1e-12)
    assert sum(terms.values()) == pytest.approx(reward, abs=1e-12)


def test_rewards_define_one_function(task: Task) -> None:
    (function,) = ast.parse(task.reward).body
    assert isinstance(function, ast.FunctionDef)
    assert [argument.arg for argument in function.args.args] == ["self", "x_velocity", "action"]


def test_healthy_ranges() -> None:
    def options(id: str) -> dict[str, Any]:
        task = get_task(id)
        return task.options(task.named(task.reference))

    assert options("ant") == {"healthy_z_range": (0.1, 2.3)}
    assert options("ant-powered") == {"healthy_z_range": (0, 10)}
    assert options("ant-desert") == {"healthy_z_range": (-10, 10)}
    assert options("ant-jump") == {"healthy_z_range": (0, 100)}
    for id in ("hopper", "walker"):
        low, high = options(id)["healthy_z_range"]
        assert low == pytest.approx(0.7) and high == math.inf
        assert options(id)["healthy_angle_range"] == (-2, 2)
    assert options("hopper")["healthy_state_range"] == (-100, 100)
    assert options("swimmer") == options("half-cheetah") == {}


def test_variants_of_ant_differ_only_where_they_should() -> None:
    ant = get_task("ant")
    for id, changed in (
        ("ant-powered", {"constants": {"gear": 300.0}}),
        ("ant-desert", {"terrain", "template"}),
        ("ant-jump", {"fitness", "reward"}),
    ):
        variant = get_task(id)
        same = {"parameters", "rules", "shapes", "environment", "constants", "template", "reward"}
        for name in same - set(changed):
            assert getattr(variant, name) == getattr(ant, name), name
    assert get_task("ant-powered").constants["gear"] == 2 * ant.constants["gear"]
    assert get_task("ant-jump").goal.name == "height"
    assert "jump" in get_task("ant-jump").description


def test_unknown_task_suggests_the_nearest() -> None:
    with pytest.raises(InputError, match=r"Did you mean 'half-cheetah'.*ant, ant-powered"):
        get_task("halfcheetah")
    with pytest.raises(InputError, match=r"no task is called 'zzz'\. Choose one of ant"):
        get_task("zzz")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("their.module:TASK", "eel = their.module:TASK does not load: ModuleNotFound"),
        ("robomore.tasks.swimmer:LINKS", "is a tuple, no Task"),
        ("robomore.tasks.swimmer:SWIMMER", "has the id 'swimmer'; give it the name of its entry"),
    ],
)
def test_broken_additions_are_named(monkeypatch: pytest.MonkeyPatch, value: str, said: str) -> None:
    entry = EntryPoint("eel", value, TASKS.group)
    monkeypatch.setattr(TASKS, "_plugins", {"eel": entry})
    with pytest.raises(InputError, match=said):
        get_task("eel")
    assert get_task("ant").id == "ant"


def test_what_is_near_a_task_file_is_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match=r"`robomore new my/biped\.xml` makes a task of it"):
        get_task("my/biped.xml")
    (tmp_path / "task.toml").write_text("")
    with pytest.raises(InputError, match=r"is a folder; name the task file, .*task\.toml"):
        get_task(str(tmp_path))
    # A folder that is called like a task that is known does not hide it.
    (tmp_path / "ant").mkdir()
    (tmp_path / "ant" / "task.toml").write_text("")
    monkeypatch.chdir(tmp_path)
    assert get_task("ant") is TASKS["ant"]
    for name in ("x" * 5_000, "a\0b"):
        with pytest.raises(InputError, match="no task is called"):
            get_task(name)
