"""The environment's source as a designer sees it: the official class with its reward taken out.

The cut is made in the syntax tree of the installed class, by reachability rather than by name: what
only the reward uses goes with it.
"""

from __future__ import annotations

import ast
import inspect
import math
import re
import sys
import textwrap
from collections.abc import Iterator
from typing import Any

from robomore.envs.own_robot_source import own_robot_source
from robomore.envs.robots import environment_class
from robomore.envs.robots.own_robot import OwnRobotEnvironment
from robomore.tasks.task import Task

REWARD = "_get_rew"

_PLACEHOLDER = f'''
def {REWARD}(self, x_velocity: float, action):
    """To be designed: returns (reward, terms), a finite number and a dict of numbers by name."""
    ...
'''

_MEANINGS = {
    "healthy_reward": "A bonus while the robot is healthy, else 0.",
    "control_cost": "A cost that grows with the action.",
    "contact_cost": "A cost that grows with the contact forces.",
}
"""What is said of the official helpers of a reward, which a designed one may call."""


def environment_source(task: Task) -> str:
    """Return the source of the task's official Gymnasium class, without its reward.

    Gone are the reward itself, the code and weights of the helpers that only it uses, and
    whatever else tells of it. The limits of health are the task's; one that depends on the
    morphology has no value.
    """
    ours = environment_class(task)
    if issubclass(ours, OwnRobotEnvironment):
        made = ours(task, task.reference, lambda self, speed, action: (0.0, {}))
        return own_robot_source(made, named=not parts_vary(task))
    official = next(base for base in ours.__mro__ if base.__module__.startswith("gymnasium."))
    module = ast.parse(inspect.getsource(sys.modules[official.__module__]))
    module.body = [node for node in module.body if _belongs(node, official.__name__)]
    robot = next(node for node in module.body if isinstance(node, ast.ClassDef))
    robot.bases = [base for base in robot.bases if "EzPickle" not in ast.unparse(base)]
    _overrule(robot, ours)
    _cut_reward(robot)
    _set_options(_methods(robot)["__init__"], task)
    return ast.unparse(ast.fix_missing_locations(module)) + "\n"


def parts_vary(task: Task) -> bool:
    """Return whether the parameters of a task say how many parts its robot has."""
    return re.search(r'<repeat\b[^>]*\bcount="[^"]*\{', task.masked_mjcf) is not None


def _belongs(node: ast.stmt, name: str) -> bool:
    """Whether a statement of the official module is worth showing."""
    if isinstance(node, ast.ClassDef):
        return node.name == name
    if isinstance(node, ast.ImportFrom):
        return [alias.name for alias in node.names] != ["utils"]
    return "__credits__" not in ast.unparse(node)


def _overrule(robot: ast.ClassDef, ours: type) -> None:
    """Show what our class says differently from the official one."""
    methods = _methods(robot)
    for name, value in vars(ours).items():
        if isinstance(value, property) and value.fget is not None and name in methods:
            text = textwrap.dedent(inspect.getsource(value.fget))
            robot.body[robot.body.index(methods[name])] = ast.parse(text).body[0]
        elif isinstance(value, tuple) and not name.startswith("__"):
            robot.body.insert(1, ast.parse(f"{name} = {value!r}").body[0])


def _cut_reward(robot: ast.ClassDef) -> None:
    if ast.get_docstring(robot) is not None:
        robot.body.pop(0)
    methods = _methods(robot)
    helpers = _only_used_by_reward(methods)
    shown = {name: node for name, node in methods.items() if name not in {*helpers, REWARD}}
    needed = {name for node in shown.values() for name in _read(node)}
    _cut_weights(methods["__init__"], needed)
    for name in helpers:
        meaning = _MEANINGS.get(name, "A number that a reward may use.")
        methods[name].body = ast.parse(f'"""{meaning}"""\n...').body
    methods[REWARD].args = _function(_PLACEHOLDER).args
    methods[REWARD].body = _function(_PLACEHOLDER).body
    for node in shown.values():
        _CutTerms().visit(node)


def _only_used_by_reward(methods: dict[str, ast.FunctionDef]) -> set[str]:
    """Return the methods that the reward uses, at first or second hand, and nothing else does."""
    found: set[str] = set()
    waiting = [REWARD]
    while waiting:
        new = (_read(methods[waiting.pop()]) & set(methods)) - found
        found |= new
        waiting += new
    while True:
        others = set(methods) - found - {REWARD}
        used = {read for name in others for read in _read(methods[name])}
        if not found & used:
            return found
        found -= used


def _cut_weights(constructor: ast.FunctionDef, needed: set[str]) -> None:
    """Drop attributes that no shown method reads, and the arguments that only they needed."""
    dropped = [
        node
        for node in constructor.body
        if "EzPickle" in ast.unparse(node) or _stores_unneeded(node, needed)
    ]
    constructor.body = [node for node in constructor.body if node not in dropped]
    left = {name for node in constructor.body for name in _names(node)}
    unneeded = {name for node in dropped for name in _names(node)} - left - {"self"}
    arguments = constructor.args
    bare = len(arguments.args) - len(arguments.defaults)
    defaults: list[ast.expr | None] = [None] * bare + [*arguments.defaults]
    kept = [
        (argument, default)
        for argument, default in zip(arguments.args, defaults, strict=True)
        if argument.arg not in unneeded
    ]
    arguments.args = [argument for argument, _ in kept]
    arguments.defaults = [default for _, default in kept if default is not None]


def _set_options(constructor: ast.FunctionDef, task: Task) -> None:
    """Show the task's own options; what depends on the morphology stands after `*`, bare."""
    reference = dict(zip(task.names, task.reference, strict=True))
    options = task.options(reference)
    others = task.options({name: 1.5 * value for name, value in reference.items()})
    arguments = constructor.args
    first = len(arguments.args) - len(arguments.defaults)
    for name, value in options.items():
        at = next((i for i, one in enumerate(arguments.args) if one.arg == name), None)
        if at is None:
            continue
        if others[name] == value:
            arguments.defaults[at - first] = _expression(value)
        else:
            arguments.kwonlyargs.append(arguments.args.pop(at))
            arguments.kw_defaults.append(None)
            arguments.defaults.pop(at - first)


class _CutTerms(ast.NodeTransformer):
    """Calls the reward, but leaves its terms alone."""

    def __init__(self) -> None:
        self._terms = ""

    def visit_Assign(self, node: ast.Assign) -> ast.AST:
        target = node.targets[0]
        if f"self.{REWARD}(" in ast.unparse(node.value) and isinstance(target, ast.Tuple):
            self._terms = ast.unparse(target.elts[1])
            target.elts[1] = ast.Name("_", ast.Store())
        return self.generic_visit(node)

    def visit_Dict(self, node: ast.Dict) -> ast.AST:
        kept = [
            (key, value)
            for key, value in zip(node.keys, node.values, strict=True)
            if key is not None or ast.unparse(value) != self._terms
        ]
        node.keys, node.values = [key for key, _ in kept], [value for _, value in kept]
        return node


def _methods(robot: ast.ClassDef) -> dict[str, ast.FunctionDef]:
    return {node.name: node for node in robot.body if isinstance(node, ast.FunctionDef)}


def _function(text: str) -> ast.FunctionDef:
    (node,) = ast.parse(text).body
    assert isinstance(node, ast.FunctionDef)
    return node


def _read(node: ast.AST) -> set[str]:
    """Return the attributes of `self` that are read."""
    return {one.attr for one in _own(node) if isinstance(one.ctx, ast.Load)}


def _stores_unneeded(node: ast.stmt, needed: set[str]) -> bool:
    if not isinstance(node, ast.Assign):
        return False
    stored = {one.attr for one in _own(node) if isinstance(one.ctx, ast.Store)}
    private = {name for name in stored if name.startswith("_")}
    return bool(private) and not needed & private


def _own(node: ast.AST) -> Iterator[ast.Attribute]:
    """Yield all `self.name` in a piece of source."""
    for one in ast.walk(node):
        if isinstance(one, ast.Attribute) and ast.unparse(one.value) == "self":
            yield one


def _names(node: ast.AST) -> set[str]:
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}


def _expression(value: Any) -> ast.expr:
    if isinstance(value, tuple):
        return ast.Tuple([_expression(item) for item in value], ast.Load())
    text = repr(value)
    if isinstance(value, float) and not math.isfinite(value):
        text = f"float('{value}')"
    return ast.parse(text, mode="eval").body
