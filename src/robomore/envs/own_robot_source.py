"""What a designer is told of the environment of a robot of one's own: what a reward may call."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterable

from robomore.envs.robots.own_robot import OwnRobotEnv, OwnRobotEnvironment

_HIDDEN = ("target_distance",)
"""What only a robot with a target has."""

_REWARD = '''
def _get_rew(self, x_velocity: float, action):
    """To be designed: returns (reward, terms), a finite number and a dict of numbers by name."""
    ...
'''


def own_robot_source(made: OwnRobotEnvironment, named: bool = True) -> str:
    """Return the public face of `OwnRobotEnv` as a class without bodies.

    Args:
        made: the robot.
        named: whether the names of its joints and sensors are told.
    """
    (module,) = ast.parse(inspect.getsource(OwnRobotEnv)).body
    assert isinstance(module, ast.ClassDef)
    methods = [
        _bare(node)
        for node in module.body
        if isinstance(node, ast.FunctionDef)
        and not node.name.startswith("_")
        and node.name not in ("step", "reset_model")
        and (made.has_target or node.name not in _HIDDEN)
    ]
    names = {
        "joints": made.joint_names,
        "contact sensors": made.contact_names,
        "sensors": made.sensor_names,
    }
    told = "".join(
        f"\n\n{kind} by name: {', '.join(found)}"
        for kind, found in names.items()
        if found and named
    )
    doc = (ast.get_docstring(module) or "") + told + "\n"
    robot = ast.ClassDef(
        name="Robot",
        bases=[ast.Name("MujocoEnv", ast.Load())],
        keywords=[],
        body=[ast.Expr(ast.Constant(doc)), *methods, *ast.parse(_REWARD).body],
        decorator_list=[],
    )
    return ast.unparse(ast.fix_missing_locations(robot)) + "\n"


def _bare(method: ast.FunctionDef) -> ast.FunctionDef:
    """Return a method whose body is its docstring alone."""
    body: Iterable[ast.stmt] = ast.parse(f'"""{ast.get_docstring(method)}"""\n...').body
    method.body = list(body)
    return method
