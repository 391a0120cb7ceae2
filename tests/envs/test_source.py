"""The source that a designer sees tells nothing of the official reward."""

from __future__ import annotations

import ast
import inspect
from typing import Any

import pytest

from paper import PAPER
from robomore.envs.robots import environment_class
from robomore.envs.source import environment_source
from robomore.tasks import TASKS

SHARED = {"healthy_reward = self.healthy_reward"}
HELPERS = ("control_cost", "contact_cost", "healthy_reward")


def official_methods(task: str) -> dict[str, ast.FunctionDef]:
    ours = environment_class(TASKS[task])
    official = next(base for base in ours.__mro__ if base.__module__.startswith("gymnasium."))
    robot = ast.parse(inspect.getsource(official)).body[0]
    assert isinstance(robot, ast.ClassDef)
    return {node.name: node for node in robot.body if isinstance(node, ast.FunctionDef)}


def shown_methods(task: str) -> dict[str, ast.FunctionDef]:
    tree = ast.parse(environment_source(TASKS[task]))
    (robot,) = (node for node in tree.body if isinstance(node, ast.ClassDef))
    return {node.name: node for node in robot.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("task", PAPER)
def test_no_statement_of_the_reward_or_its_helpers_is_left(task: str) -> None:
    text = environment_source(TASKS[task])
    methods = official_methods(task)
    for name in ("_get_rew", *(name for name in HELPERS if name in methods)):
        for statement in methods[name].body:
            for line in ast.unparse(statement).splitlines():
                if line.strip() not in "})":
                    assert line.strip() not in text, name


@pytest.mark.parametrize("task", PAPER)
@pytest.mark.parametrize(
    "word",
    [
        "reward_forward", "reward_ctrl", "reward_contact", "reward_survive", "reward_info",
        "forward_reward", "ctrl_cost", "_weight", "EzPickle", "_healthy_reward", "utils",
        "## Rewards", "default is", "0.0005", "5e-4", "0.001", "1e-3", "0.0001", "1e-4",
    ],
)  # fmt: skip
def test_no_word_of_the_reward_is_left(task: str, word: str) -> None:
    assert word not in environment_source(TASKS[task])


@pytest.mark.parametrize("task", PAPER)
def test_no_argument_or_number_is_a_weight(task: str) -> None:
    constructor = shown_methods(task)["__init__"].args
    for argument in (*constructor.args, *constructor.kwonlyargs):
        assert "weight" not in argument.arg and "reward" not in argument.arg
    tree = ast.parse(environment_source(TASKS[task]))
    numbers = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    assert not numbers & {0.5, 5e-4, 1e-3, 1e-4}


@pytest.mark.parametrize("task", PAPER)
def test_the_rest_of_the_class_is_there(task: str) -> None:
    official, shown = official_methods(task), shown_methods(task)
    assert shown.keys() == official.keys()
    for name in ("_get_obs", "reset_model", "_get_reset_info"):
        assert ast.unparse(shown[name]) == ast.unparse(official[name])
    assert "x_velocity" in ast.unparse(shown["step"])
    assert "self._get_rew(x_velocity, action)" in ast.unparse(shown["step"])
    assert [argument.arg for argument in shown["_get_rew"].args.args] == [
        "self", "x_velocity", "action",
    ]  # fmt: skip


@pytest.mark.parametrize("task", PAPER)
def test_helpers_are_named_with_their_signature(task: str) -> None:
    official, shown = official_methods(task), shown_methods(task)
    for name in HELPERS:
        if name in official:
            assert ast.unparse(shown[name].args) == ast.unparse(official[name].args)
            assert [ast.unparse(one) for one in shown[name].decorator_list] == [
                ast.unparse(one) for one in official[name].decorator_list
            ]
            assert len(shown[name].body) == 2  # one sentence and an ellipsis


@pytest.mark.parametrize("task", PAPER)
def test_limits_of_health_are_the_tasks(task: str) -> None:
    constructor = shown_methods(task)["__init__"].args
    values: dict[str, Any] = {argument.arg: None for argument in constructor.kwonlyargs}
    arguments = constructor.args[-len(constructor.defaults) :]
    for argument, default in zip(arguments, constructor.defaults, strict=True):
        values[argument.arg] = default
    reference = dict(zip(TASKS[task].names, TASKS[task].reference, strict=True))
    for name, value in TASKS[task].options(reference).items():
        if values[name] is not None:
            assert ast.unparse(values[name]) == ast.unparse(ast.parse(str(value)))
    # A limit that follows from the body would tell the official body.
    if task in ("hopper", "walker"):
        assert values["healthy_z_range"] is None


def test_the_walkers_health_is_shown_as_it_is() -> None:
    shown = ast.unparse(shown_methods("walker")["is_healthy"])
    assert shown == ast.unparse(official_methods("hopper")["is_healthy"])
    assert "_healthy_state_range = (-100.0, 100.0)" in environment_source(TASKS["walker"])


@pytest.mark.parametrize("task", PAPER)
def test_it_is_python_without_long_gaps(task: str) -> None:
    text = environment_source(TASKS[task])
    compile(text, "shown", "exec")
    assert "\n\n\n" not in text
