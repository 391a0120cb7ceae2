"""Builds a task from a robot and a plan of what is free and what is to be done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import mujoco

from robomore.envs.motor_force import joint_of
from robomore.envs.rest_pose import rest_pose
from robomore.errors import InputError
from robomore.importer.edits import MASS_MODES, Edit, MassMode, MotorGroup
from robomore.importer.feet import contact_names
from robomore.importer.limbs import find_links
from robomore.importer.loops import refuse_strain
from robomore.importer.motors import followers
from robomore.importer.ranges import one_sided, within_ranges
from robomore.importer.reading import SIMPLE_JOINTS, Robot
from robomore.importer.template import TemplateWriter
from robomore.tasks.fitness import Fitness
from robomore.tasks.portable import ENVIRONMENT, FixedOptions, refuse_files, refuse_texts
from robomore.tasks.task import Parameter, Task
from robomore.tasks.template import fill

TARGET = "target_place"
"""Name of the site at the place that is to be reached."""

_ROUNDING = 1e-3
"""Relative difference of a rate that nobody asks about."""


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
        healthy_height: least and greatest height in multiples of that at rest.
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
    healthy_height: tuple[float, float]
    target: tuple[str, tuple[float, float, float]] | None


def build(robot: Robot, plan: Plan) -> tuple[Task, tuple[str, ...]]:
    """Return the task, and what was chosen or changed on the way, in words.

    Raises:
        InputError: the robot has no motors, or the plan names parts that it lacks.
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
    notes += moved + one_sided(rest, rest_pose(rest, home, plan.upright), plan.reach)
    for one, other in _overlaps(rest, home, plan.upright):
        writer.add("contact", "exclude", name=f"{one}-{other}", body1=one, body2=other)
        notes.append(f"`{one}` and `{other}` overlap at rest: they do not touch each other")
    step = float(rest.opt.timestep)
    frame_skip = max(1, round(1 / (plan.control_hz * step)))
    if abs((got := 1 / (frame_skip * step)) - plan.control_hz) > _ROUNDING * plan.control_hz:
        notes.append(
            f"control_hz = {plan.control_hz:g} is {got:.4g} here: a control step is a whole number "
            f"of the robot's time steps of {step:g} s"
        )
    notes += _followers(rest)
    options = {
        "frame_skip": frame_skip,
        "home": dict(home),
        "upright": list(plan.upright),
        "healthy_tilt": None if plan.tilt_degrees is None else math.radians(plan.tilt_degrees),
        "healthy_height": list(plan.healthy_height),
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


def _overlaps(
    model: mujoco.MjModel, home: Mapping[str, float], upright: tuple[float, ...]
) -> list[tuple[str, str]]:
    """Return pairs of links that are inside each other at rest."""
    data = mujoco.MjData(model)
    data.qpos[:] = rest_pose(model, home, upright)
    mujoco.mj_forward(model, data)
    pairs: dict[tuple[str, str], None] = {}  # in their order
    for contact in data.contact:
        one, other = (int(model.geom_bodyid[geom]) for geom in contact.geom)
        pair = (model.body(one).name, model.body(other).name)
        if contact.dist < 0 and one and other:
            pairs[pair] = None
    return list(pairs)
