"""Builds a task from a robot and a plan of what is free and what is to be done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.motor_force import joint_of
from robomore.envs.rest_pose import rest_pose
from robomore.envs.root import SIMPLE_JOINTS, find_root
from robomore.errors import InputError
from robomore.importer.edits import MASS_MODES, Edit, MassMode, MotorGroup
from robomore.importer.feet import contact_names
from robomore.importer.goal_faults import refuse_goal
from robomore.importer.left_out import FLOOR
from robomore.importer.limbs import find_links
from robomore.importer.loops import refuse_strain
from robomore.importer.motors import followers
from robomore.importer.ranges import one_sided, within_ranges
from robomore.importer.reading import Robot
from robomore.importer.rest import lies_low
from robomore.importer.template import TemplateWriter
from robomore.tasks.fitness import Fitness
from robomore.tasks.portable import ENVIRONMENT, FixedOptions, refuse_files, refuse_texts
from robomore.tasks.task import Parameter, Task
from robomore.tasks.template import fill

_SUNK = 0.001
"""Depth in m inside the floor that a robot which is fixed to the world may rest at."""

_SAME = 1e-3
"""Share of a robot's mass and size by which its template may miss them: digits are few in MJCF."""

TARGET = "target_place"
"""Name of the site at the place that is to be reached."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What a task file asks for, with all names resolved.

    Attributes:
        id: of the task.
        title: in reports.
        description: in words, for designers.
        fitness: what is measured.
        reward: text of the reference reward.
        parameters: the free dimensions.
        edits: what each of them changes.
        motors: that are added.
        mass: how mass follows from size.
        payload: fraction of a link's mass that stays as it is in the mode `shell`.
        control_hz: control steps in a second.
        episode_seconds: length of a full episode.
        reset_noise: see `OwnRobotEnv`.
        reach: see `OwnRobotEnv`.
        sensors: names of the sensors that are observed.
        home: pose at rest by joint.
        upright: orientation of a free root at rest.
        tilt_degrees: largest tilt of a free root, `None` for any.
        healthy_height: least and greatest height in multiples of that at rest, `None` for any.
        target: site or link that is to reach a place, and the place.
    """

    id: str
    title: str
    description: str
    fitness: Fitness
    reward: str
    parameters: tuple[Parameter, ...]
    edits: tuple[Edit, ...]
    motors: tuple[MotorGroup, ...]
    mass: MassMode
    payload: float
    control_hz: float
    episode_seconds: float
    reset_noise: float
    reach: float
    sensors: tuple[str, ...]
    home: Mapping[str, float]
    upright: tuple[float, ...]
    tilt_degrees: float | None
    healthy_height: tuple[float, float] | None
    target: tuple[str, tuple[float, float, float]] | None


def build(robot: Robot, plan: Plan) -> tuple[Task, tuple[str, ...]]:
    """Return the task, and what was chosen or changed on the way, in words.

    Raises:
        InputError: the robot has no motors, the plan names parts that it lacks, or the template is
            another robot at the reference.
    """
    notes: list[str] = []
    writer = TemplateWriter(robot, plan.edits, plan.motors, plan.mass, plan.payload)
    model = robot.spec().compile()
    for name, body in contact_names(model).items():
        writer.add(
            "sensor",
            "contact",
            name=f"contact_{name}",
            body1=body,
            num="1",
            reduce="netforce",
            data="found force",
        )
    if plan.target:
        _add_target(writer, model, *plan.target)
    reference = {one.name: one.reference for one in plan.parameters}
    rest = mujoco.MjSpec.from_string(fill(writer.text(), reference), assets=robot.assets).compile()
    if not rest.nu:
        raise InputError(
            f"{plan.id}: the robot has no motors, so nothing can be learned; add an <actuator> "
            "section to its MJCF, or [[actuator]] tables to the task file"
        )
    _refuse_another_robot(plan.id, model, rest)
    _refuse_to_fall(plan.id, rest)
    known = [rest.sensor(number).name for number in range(rest.nsensor)]
    if missing := [name for name in plan.sensors if name not in known]:
        raise InputError(
            f"{plan.id}: sensors = {missing}: there are {', '.join(known) or 'no sensors'}"
        )
    joints = [
        rest.joint(n).name for n in range(rest.njnt) if int(rest.jnt_type[n]) in SIMPLE_JOINTS
    ]
    usual = {name: float(rest.qpos0[rest.joint(name).qposadr[0]]) for name in joints}
    home, moved = within_ranges(
        rest, {name: plan.home.get(name, usual[name]) for name in joints}, "the rest pose"
    )
    pose = rest_pose(rest, home, plan.upright)
    notes += moved + one_sided(rest, pose, plan.reach)
    refuse_goal(plan.id, plan.fitness, rest, pose)
    _refuse_low_root(plan, rest, pose)
    for one, other in _overlaps(rest, pose):
        writer.add("contact", "exclude", body1=one, body2=other)
        notes.append(f"`{one}` and `{other}` overlap at rest: they do not touch each other")
    for link, depth in _sunk(rest, pose).items():
        writer.add("contact", "exclude", body1="world", body2=link)
        notes.append(
            f"`{link}` is {depth:.2g} m inside the floor at rest: it does not touch the floor; if "
            "it should, place the robot higher in its file"
        )
    step = float(rest.opt.timestep)
    frame_skip = max(1, round(1 / (plan.control_hz * step)))
    if not math.isclose(hz := 1 / (frame_skip * step), plan.control_hz, rel_tol=0.01):
        notes.append(
            f"control_hz = {plan.control_hz:g} is no whole number of time steps of {step:g} s: it "
            f"is {hz:.4g}; change it, or the timestep in the robot's file"
        )
    notes += _followers(rest)
    options = {
        "frame_skip": frame_skip,
        "home": dict(home),
        "upright": list(plan.upright),
        "healthy_tilt": None if plan.tilt_degrees is None else math.radians(plan.tilt_degrees),
        "healthy_height": plan.healthy_height and list(plan.healthy_height),
        "reset_noise": plan.reset_noise,
        "reach": plan.reach,
        "sensors": [*plan.sensors, *(["target"] if plan.target else [])],
        "tip": plan.target[0] if plan.target else "",
    }
    template = writer.text()
    if rest.neq or rest.ntendon:
        stands = partial(rest_pose, home=home, upright=plan.upright)
        refuse_strain(plan.id, template, plan.parameters, robot.assets, stands)
    refuse_files(plan.id, template, robot.assets)
    task = Task(
        id=plan.id,
        title=plan.title,
        description=plan.description,
        fitness=plan.fitness,
        template=template,
        parameters=plan.parameters,
        reward=plan.reward,
        environment=ENVIRONMENT,
        options=FixedOptions(options),
        episode_steps=max(1, round(plan.episode_seconds / (frame_skip * step))),
        assets=robot.assets,
        mesh_volumes=writer.mesh_volumes,
        mass=f"{plan.mass}: {MASS_MODES[plan.mass]}",
        radii=tuple(edit.name for edit in plan.edits if edit.changes == "radius"),
    )
    refuse_texts(task)
    return task, tuple(notes)


def _add_target(
    writer: TemplateWriter,
    model: mujoco.MjModel,
    part: str,
    position: tuple[float, float, float],
) -> None:
    sites = [model.site(number).name for number in range(model.nsite)]
    links = list(find_links(model))
    if part not in (*sites, *links):
        raise InputError(
            f"[target] part = {part!r}: the robot has the sites {', '.join(sites) or '(none)'} and "
            f"the links {', '.join(links)}"
        )
    at = " ".join(f"{number:.9g}" for number in position)
    writer.add("worldbody", "site", name=TARGET, pos=at, size="0.02", rgba="0.9 0.2 0.2 1")
    writer.add(
        "sensor",
        "framepos",
        name="target",
        objtype="site",
        objname=TARGET,
        reftype="site" if part in sites else "xbody",
        refname=part,
    )


def _followers(model: mujoco.MjModel) -> list[str]:
    """Return notes on joints that an equality, such as a URDF's `mimic`, makes follow others."""
    driven = {joint_of(model, motor) for motor in range(model.nu)}
    notes = []
    for follower, leader in followers(model).items():
        moved = "its own motor works against that" if follower in driven else "it has no motor"
        one, other = model.joint(follower).name, model.joint(leader).name
        notes.append(f"the joint `{one}` follows `{other}`, and {moved}")
    return notes


def _refuse_low_root(plan: Plan, model: mujoco.MjModel, pose: NDArray[np.float64]) -> None:
    """Refuse limits of the height in multiples of one that is next to nothing.

    Raises:
        InputError: with the remedy.
    """
    if plan.healthy_height and lies_low(model, pose):
        raise InputError(
            f"{plan.id}: the root `{model.body(1).name}` rests on the floor, so that [health] "
            f"height = {list(plan.healthy_height)} in multiples of its height ends every episode; "
            "leave that line out, or place the root's frame higher up in the robot's file"
        )


def _refuse_another_robot(id: str, read: mujoco.MjModel, made: mujoco.MjModel) -> None:
    """Refuse a template that does not give the robot back which was read.

    Raises:
        InputError: with what differs.
    """
    faults = []
    masses = [float(one.body_mass[1:].sum()) for one in (read, made)]
    if not math.isclose(*masses, rel_tol=_SAME):
        faults.append(f"it weighs {masses[1]:.4g} kg and not {masses[0]:.4g} kg")
    for geom in np.flatnonzero(read.geom_bodyid):
        name = read.geom(geom).name
        sizes = [float(one.geom_rbound[one.geom(name).id]) for one in (read, made)]
        if not math.isclose(*sizes, rel_tol=_SAME):
            faults.append(
                f"the solid `{name}` reaches {sizes[1]:.4g} m from its middle and not "
                f"{sizes[0]:.4g} m"
            )
    if faults:
        raise InputError(
            f"{id}: the robot that its template makes at the reference is not the one that was "
            f"read: {faults[0]}; write the attributes of that part at the part itself, without a "
            "class of defaults"
        )


def _refuse_to_fall(id: str, model: mujoco.MjModel) -> None:
    """Refuse a robot that moves and falls through the floor, as no solid of it can touch it.

    Raises:
        InputError: with the remedy.
    """
    floor = model.geom(FLOOR).id
    bits = model.geom_contype | model.geom_conaffinity
    touching = bits[model.geom_bodyid > 0].any() or floor in (*model.pair_geom1, *model.pair_geom2)
    if find_root(model).moves and not touching:
        raise InputError(
            f"{id}: no solid of the robot touches anything (contype and conaffinity are 0), so it "
            "falls through the floor; give those that stand on it a contype of 1 in its file"
        )


def _sunk(model: mujoco.MjModel, pose: NDArray[np.float64]) -> dict[str, float]:
    """Return how deep in m links are inside the floor in the pose at rest (nq,)."""
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    mujoco.mj_forward(model, data)
    found: dict[str, float] = {}
    for contact in data.contact:
        one, other = sorted(int(model.geom_bodyid[geom]) for geom in contact.geom)
        if one == 0 and contact.dist < -_SUNK:
            name = model.body(other).name
            found[name] = max(found.get(name, 0.0), -float(contact.dist))
    return found


def _overlaps(model: mujoco.MjModel, pose: NDArray[np.float64]) -> list[tuple[str, str]]:
    """Return pairs of links that are inside each other in the pose at rest (nq,)."""
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    mujoco.mj_forward(model, data)
    pairs: dict[tuple[str, str], None] = {}  # in their order
    for contact in data.contact:
        one, other = (int(model.geom_bodyid[geom]) for geom in contact.geom)
        pair = (model.body(one).name, model.body(other).name)
        if contact.dist < 0 and one and other:
            pairs[pair] = None
    return list(pairs)
