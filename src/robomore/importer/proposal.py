"""Proposes a task for a robot: what is free, how it rests, what moves it, and what it is to do."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np

from robomore.envs.rest_pose import rest_pose
from robomore.envs.root import SIMPLE_JOINTS, find_root
from robomore.errors import InputError
from robomore.importer.edits import MASS_MODES, MotorGroup
from robomore.importer.feet import contact_names
from robomore.importer.limbs import Link, find_links, groups, kind
from robomore.importer.loops import tied
from robomore.importer.motors import ProposedMotors, propose_motors
from robomore.importer.reading import Robot
from robomore.importer.rest import Rest, lies_low, propose_home
from robomore.importer.strength import strength_of
from robomore.plain_files import cannot_write
from robomore.tasks.registry import TASKS

Goal = Literal["distance", "economy"]
"""What a robot that moves freely is to do: to get far, or with little energy."""

TASK_FILE, ROBOT_FILE = "task.toml", "robot.xml"

_MOST_NOTES = 8
"""Notes of the reading that a task file repeats."""

_MOST_GROUPS = 6
"""Groups of links that are proposed as free, the longest ones."""

_LEAST_SHARE = 0.25
"""Links shorter than this fraction of the longest one are not proposed as free."""

_HEIGHT = "height = [0.5, 2.0]  # of the root, in multiples of that at rest"

_REACH = "reach = 0.35  # fraction of each control range that actions use"
"""For servos, since smaller motions are learnt sooner; motors would lack torque."""

_SIDEWAYS = "    sideways = -0.5 * abs(self.data.qvel[1]) - 0.5 * abs(self.heading)\n"
_SIDEWAYS_TERM = '"sideways": sideways, '
"""What a reward says that a robot in a plane cannot do."""

_WALKING = '''def _get_rew(self, x_velocity, action):
    """Forward speed, a bonus for staying upright, less the cost of effort."""
    forward = 2.0 * min(x_velocity, 2.0)
    upright = np.cos(self.tilt)
    sideways = -0.5 * abs(self.data.qvel[1]) - 0.5 * abs(self.heading)
    effort = -0.05 * float(np.square(action).mean())
    terms = {"forward": forward, "upright": upright, "sideways": sideways, "effort": effort}
    return sum(terms.values()), terms
'''
_ECONOMY = '''def _get_rew(self, x_velocity, action):
    """Forward speed up to 1.5 m/s, upright and straight, less the power that the motors take."""
    forward = 2.0 * min(x_velocity, 1.5)
    upright = np.cos(self.tilt)
    sideways = -0.5 * abs(self.data.qvel[1]) - 0.5 * abs(self.heading)
    watts = float(np.abs(self.data.actuator_force * self.data.actuator_velocity).sum())
    power = -watts / WATTS
    terms = {"forward": forward, "upright": upright, "sideways": sideways, "power": power}
    return sum(terms.values()), terms
'''
_COSTLY = 12.0
"""Speed in m/s at which the power that lifts the robot's weight costs a reward of 1. With a third
of it Unitree's Go1 learnt to stand still, which takes no power."""
_REACHING = '''def _get_rew(self, x_velocity, action):
    """Closeness of the tip to the target, less the cost of effort."""
    near = 1.0 - float(np.tanh(3.0 * self.target_distance))
    effort = -0.05 * float(np.square(action).mean())
    return near + effort, {"near": near, "effort": effort}
'''


def write_proposal(
    robot: Robot,
    source: Path,
    out: Path,
    free: Sequence[str] = (),
    goal: Goal | None = None,
    name: str | None = None,
) -> Path:
    """Write a task file, the robot and its meshes into a new folder; returns the task file.

    Args:
        robot: as it was read.
        source: the file that it was read from.
        out: the folder.
        free: patterns of the parameters or groups of links that are to be free; by default the
            length and thickness of the longest links.
        goal: what the robot is to do; by default to get far, or to reach a target if it is fixed.
        name: of the task; by default that of the source.

    Raises:
        InputError: a pattern fits nothing, the robot is fixed and cannot have that goal, an
            installed task has that name, or the folder cannot be written.
    """
    text = proposal(robot, name or source.stem, free, goal)
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name, data in robot.assets.items():
            (out / name).write_bytes(data)
        (out / ROBOT_FILE).write_text(robot.xml, encoding="utf-8")
        (out / TASK_FILE).write_text(text, encoding="utf-8")
    except OSError as error:
        raise cannot_write(out, error, "name another folder with --out") from None
    return out / TASK_FILE


def proposal(robot: Robot, name: str, free: Sequence[str] = (), goal: Goal | None = None) -> str:
    """Return the text of a task file for a robot; see `write_proposal`."""
    if (id := identifier(name)) in TASKS:
        raise InputError(f"{id!r} is the id of an installed task; give another one with --name")
    model = robot.spec().compile()
    proposed = propose_motors(model)
    motors = [one.group for one in proposed]
    moves = find_root(model).moves
    if goal and not moves:
        raise InputError(
            f"--goal {goal} is for a robot that moves freely, and this one is fixed to the world: "
            "leave --goal out, or give --base free"
        )
    stated = any(body.explicitinertial for body in robot.spec().bodies)
    lines = [
        "# A task of RoboMoRe, made from a robot's file. Edit it as you like;",
        "# `robomore check-task` says what is wrong with it and how it was understood.",
        *(f"# Note: {note}." for note in robot.notes[:_MOST_NOTES]),
        f"id = {_text(id)}",
        f"title = {_text(name.replace('_', ' ').replace('-', ' ').title())}",
        f'description = """{_multiline(_description(model, moves, goal))}"""',
        f"robot = {_text(ROBOT_FILE)}",
        "",
        *_goal(model, moves, goal),
        "",
        *(f"# {mode}: {meaning}." for mode, meaning in MASS_MODES.items()),
        f"mass = {_text('length' if stated else 'density')}",
        "",
        "control_hz = 50",
        "episode_seconds = 20",
        *([_REACH] if moves and _has_servos(model, motors) else []),
        "",
    ]
    if find_root(model).base == "free" and not np.allclose(robot.upright, (1.0, 0.0, 0.0, 0.0)):
        upright = [float(f"{number:.9g}") for number in robot.upright]
        lines += ["[home]", f"upright = {upright}  # of the root at rest, as w, x, y, z", ""]
    home = propose_home(robot, model)
    if home:
        lines += ["[home.joints]  # the pose at rest: rad, or m for sliding joints"]
        lines += [f"{_key(joint)} = {_rest(rest)}" for joint, rest in home.items()] + [""]
    if moves:
        pose = rest_pose(model, {name: at.value for name, at in home.items()}, robot.upright)
        lines += [
            "[health]  # an episode ends early beyond these limits",
            "tilt_degrees = 60",
            *([] if lies_low(model, pose) else [_HEIGHT]),
            "",
        ]
    else:
        lines += ["[target]", f"part = {_text(_tip(model))}", f"position = {_place(model)}", ""]
    for one in proposed:
        lines += _actuator(one)
    found = _parameters(model, motors)
    for parameter in _chosen(found, free):
        lines += parameter
    return "\n".join(lines).rstrip() + "\n"


def _rest(rest: Rest) -> str:
    return f"{rest.value:g}" + (f"  # {rest.reason}" if rest.reason else "")


def _has_servos(model: mujoco.MjModel, motors: Sequence[MotorGroup]) -> bool:
    """Return whether anything is held in a position, by the robot's own motors or proposed ones."""
    own = model.actuator_biastype != mujoco.mjtBias.mjBIAS_NONE
    return bool(own.any()) or any(group.kind == "servo" for group in motors)


def _goal(model: mujoco.MjModel, moves: bool, goal: Goal | None) -> list[str]:
    fitness, reward = ("distance", _WALKING) if moves else ("target-reached", _REACHING)
    if goal == "economy":
        weight = float(model.body_mass.sum()) * 9.81
        fitness = "transport-economy"
        reward = _ECONOMY.replace("WATTS", str(float(f"{_COSTLY * weight:.2g}")))
    if find_root(model).base == "planar":
        reward = reward.replace(_SIDEWAYS, "").replace(_SIDEWAYS_TERM, "")
    return [f"fitness = {_text(fitness)}", f"reward = '''\n{reward}'''"]


def _parameters(
    model: mujoco.MjModel, motors: Sequence[MotorGroup]
) -> dict[str, tuple[bool, list[str]]]:
    """Return all parameters by name: whether one is free by default, and its lines."""
    links = groups(find_links(model), model)
    limbs = sorted(links, key=lambda one: -one[1][0].length)
    longest = max((group[0].length for _, group in limbs), default=0.0)
    usual = [
        name for name, group in limbs[:_MOST_GROUPS] if group[0].length >= _LEAST_SHARE * longest
    ]
    found: dict[str, tuple[bool, list[str]]] = {}
    kept = tied(model)  # one length alone would open a closed chain
    for name, group in links:
        if group[0].length:
            length = max(link.length for link in group)
            lines = _parameter(f"{name}_length", "length", _names(group), length, "length of")
            alone = not any(link.body in kept for link in group)
            found[f"{name}_length"] = name in usual and alone, lines
        if group[0].radius:
            radius = max(link.radius for link in group)
            lines = _parameter(f"{name}_radius", "radius", _names(group), radius, "radius of")
            found[f"{name}_radius"] = name in usual and bool(group[0].length), lines
    strengths: dict[str, dict[str, float]] = {}
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) in SIMPLE_JOINTS:
            joint_name = model.joint(joint).name
            if strength := strength_of(model, motors, joint_name):
                strengths.setdefault(kind(joint_name), {})[joint_name] = strength
    for name, alike in strengths.items():
        strongest, said = max(alike.values()), "largest torque of the motors of"
        lines = _parameter(f"{name}_strength", "strength", list(alike), strongest, said)
        found[f"{name}_strength"] = False, lines
    return found


def _chosen(found: dict[str, tuple[bool, list[str]]], free: Sequence[str]) -> list[list[str]]:
    """Return the lines of the parameters that `free` asks for.

    Raises:
        InputError: a pattern fits none.
    """
    if not free:
        chosen = [name for name, (usual, _) in found.items() if usual]
    else:
        chosen = []
        for pattern in free:
            fits = [name for name in found if fnmatchcase(name, pattern)]
            fits = fits or [
                name
                for name in found
                if fnmatchcase(name.rpartition("_")[0], pattern) and not name.endswith("_strength")
            ]
            if not fits:
                raise InputError(
                    f"--free {pattern}: nothing fits; there are {', '.join(found) or 'none'}"
                )
            chosen += [name for name in fits if name not in chosen]
    if not chosen:
        raise InputError(
            "no limb was found whose length or thickness could be free; a limb is a link with a "
            "geom that hangs from another link by a joint"
        )
    return [found[name][1] for name in chosen]


def _parameter(
    name: str, changes: str, parts: Sequence[str], reference: float, meaning: str
) -> list[str]:
    what = parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
    return [
        "[[parameter]]",
        f"name = {_text(name)}",
        f"changes = {_text(changes)}",
        f"of = {json.dumps(list(parts))}",
        f"low = {reference / 2:.2g}",
        f"high = {reference * 2:.2g}",
        f"meaning = {_text(f'{meaning} {what}')}",
        "",
    ]


def _actuator(proposed: ProposedMotors) -> list[str]:
    group = proposed.group
    lines = [
        "[[actuator]]  # a proposal: give what your motors have",
        f"joints = {json.dumps(list(group.joints))}",
        f"kind = {_text(group.kind)}",
        f"torque = {group.torque:g}  # N·m: {proposed.reason}",
    ]
    if group.kind == "servo":
        lines += [f"stiffness = {group.stiffness:g}", f"damping = {group.damping:g}"]
    return [*lines, f"armature = {group.armature:g}", ""]


def _description(model: mujoco.MjModel, moves: bool, goal: Goal | None) -> str:
    links = groups(find_links(model), model)
    parts = [f"{len(group)} x {name}" if len(group) > 1 else name for name, group in links]
    root = find_root(model)
    joints = sum(int(kind) in SIMPLE_JOINTS for kind in model.jnt_type)
    joints -= len(root.joints) if root.base == "planar" else 0
    base = {
        "free": "that moves freely",
        "planar": "that moves in the plane of x and z",
        "fixed": "whose base is fixed to the ground",
    }[root.base]
    feet = list(contact_names(model))
    ends = f" Its limbs end in {', '.join(feet)}." if feet else ""
    said = (
        "The goal is to move forward, in the direction of +x, with as little energy as possible."
        if goal == "economy"
        else "The goal is to move forward, in the direction of +x, as far as possible."
        if moves
        else "The goal is to bring the tip to the target and to hold it there."
    )
    return f"A robot {base}, with {joints} joints. Its links are {', '.join(parts)}.{ends}\n{said}"


def _tip(model: mujoco.MjModel) -> str:
    """Return the part of an arm that is to reach a target: its last site, or its last link."""
    if sites := [site for site in range(model.nsite) if model.site_bodyid[site]]:
        return str(model.site(sites[-1]).name)
    return str(model.body(model.nbody - 1).name)


def _place(model: mujoco.MjModel) -> list[float]:
    """Return a place that an arm can reach: before its base, four tenths as far as it is long."""
    reach = sum(link.length for link in find_links(model).values())
    return [round(share * reach, 2) for share in (0.25, 0.15, 0.25)]


def _names(group: Sequence[Link]) -> list[str]:
    return [link.name for link in group]


def identifier(name: str) -> str:
    """Return the id of a task that is called so."""
    return "".join(one if one.isalnum() else "-" for one in name.lower()).strip("-") or "robot"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _multiline(text: str) -> str:
    """Return a text as it stands between three quotes, which read a backslash as TOML does."""
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)
