"""Facts of a task's robot for the prompts, read from its compiled model and its environment.

They hold names, indices and limits, and no number of a morphology. The simulator is imported here
alone, and only when a prompt is made.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

from robomore.designers.llm.tables import table
from robomore.tasks.geometry import Capsule
from robomore.tasks.task import Task
from robomore.types import Morphology

_FREE_PARTS = (
    "{q0}:{q3} position x, y, z (m), {q3}:{q7} orientation as a quaternion w, x, y, z",
    "{v0}:{v3} velocity along the world's axes (m/s), {v3}:{v6} angular velocity about the body's "
    "own axes (rad/s)",
)


_ONE_OF_MANY = (
    "How many parts the robot has depends on the morphology. What follows is one morphology, as an "
    "example; others have more parts or fewer, and then the same index is another part. So write "
    "no index but the root's into the code: ask for parts by name where they exist, or go through "
    "all that there are."
)


def robot_layout(task: Task) -> str:
    """Return the joints, bodies, geoms, motors and sensors of the robot with their indices."""
    import mujoco

    from robomore.envs.compile import compile_model
    from robomore.envs.source import parts_vary

    vary = parts_vary(task)
    other = _second(task) if vary else None
    model = other.model if other is not None else compile_model(task, task.reference)
    # A limit that depends on the morphology would tell of the reference morphology.
    fixed = not re.search(r'\b(range|gear)="[^"]*\{', task.masked_mjcf)

    def name(kind: mujoco.mjtObj, index: int) -> str:
        return mujoco.mj_id2name(model, kind, index) or f"(number {index})"

    lines = [_ONE_OF_MANY, ""] if vary else []
    lines += [
        f"`self.data.qpos` has {model.nq} numbers, `self.data.qvel` has {model.nv}. A joint holds "
        "these of them:",
        "",
        *table(
            ("joint", "type", "moves", "qpos", "qvel", "range"),
            list(_joints(model, name, fixed)),
        ),
        "",
        f"These are the {model.nbody} bodies, each with its geoms. The number of a body is its "
        "index in `xpos`, `xquat`, `cvel` and `cfrc_ext`, that of a geom its index in `geom_xpos`. "
        "`self.data.cfrc_ext[body]` holds what touches the body: a torque in [0:3] and a force in "
        "[3:6].",
        "",
    ]
    for body in range(model.nbody):
        geoms = [
            f"{geom} {name(mujoco.mjtObj.mjOBJ_GEOM, geom)}"
            for geom in range(model.ngeom)
            if model.geom_bodyid[geom] == body
        ]
        parent = name(mujoco.mjtObj.mjOBJ_BODY, int(model.body_parentid[body]))
        within = f" (on {parent})" if body else ""
        lines.append(
            f"- body {body} {name(mujoco.mjtObj.mjOBJ_BODY, body)}{within}: "
            + (f"geom {', '.join(geoms)}" if geoms else "no geom")
        )
    motors = []
    for motor in range(model.nu):
        of_joint = model.actuator_trntype[motor] == mujoco.mjtTrn.mjTRN_JOINT
        kind = mujoco.mjtObj.mjOBJ_JOINT if of_joint else mujoco.mjtObj.mjOBJ_ACTUATOR
        joint = name(kind, int(model.actuator_trnid[motor, 0]) if of_joint else motor)
        gear = f" (gear {model.actuator_gear[motor, 0]:g})" if fixed else ""
        motors.append(f"[{motor}] {joint}{gear}")
    lines += ["", f"`action` has {model.nu} numbers, one for the motor of each joint: "]
    lines[-1] += ", ".join(motors) + "."
    lines.append("")
    if model.nsensor:
        lines += ["`self.data.sensordata` holds these sensors:", ""]
        for sensor in range(model.nsensor):
            start, size = int(model.sensor_adr[sensor]), int(model.sensor_dim[sensor])
            place = str(start) if size == 1 else f"{start}:{start + size}"
            lines.append(f"- [{place}] {name(mujoco.mjtObj.mjOBJ_SENSOR, sensor)}")
    else:
        lines.append("The model has no sensors.")
    return "\n".join(lines)


def _joints(model: Any, name: Any, fixed: bool) -> Iterator[tuple[str, ...]]:
    import mujoco

    for joint in range(model.njnt):
        q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        kind = mujoco.mjtJoint(int(model.jnt_type[joint])).name.removeprefix("mjJNT_").lower()
        unit = "m" if kind == "slide" else "rad"
        places = (str(q), str(v))
        if kind == "free":
            numbers = {f"q{i}": q + i for i in (0, 3, 7)} | {f"v{i}": v + i for i in (0, 3, 6)}
            places = (_FREE_PARTS[0].format(**numbers), _FREE_PARTS[1].format(**numbers))
        elif kind == "ball":
            places = (f"{q}:{q + 4}", f"{v}:{v + 3}")
        limits = ""
        if model.jnt_limited[joint] and fixed:
            low, high = model.jnt_range[joint]
            limits = f"{low:.3g} to {high:.3g} {unit}"
        yield (
            name(mujoco.mjtObj.mjOBJ_JOINT, joint),
            kind,
            name(mujoco.mjtObj.mjOBJ_BODY, int(model.jnt_bodyid[joint])),
            *places,
            limits,
        )


def episode_facts(task: Task) -> str:
    """Return the control step, how an episode starts, and what ends it."""
    made = _environment(task, task.reference)
    dt, substeps = float(made.dt), int(made.frame_skip)
    lines = [
        f"- A control step takes {dt:g} s of simulated time ({substeps} steps of {dt / substeps:g} "
        f"s). A full episode has {task.episode_steps:,} control steps, which is "
        f"{task.episode_steps * dt:g} s.",
    ]
    noise = getattr(made, "_reset_noise_scale", None)
    if isinstance(noise, int | float):
        lines.append(
            "- An episode starts in the pose of the MJCF file with random noise: up to about "
            f"{noise:g} (m, rad) on each position, and about as much (m/s, rad/s) on each velocity."
        )
    if not getattr(made, "_terminate_when_unhealthy", False):
        lines.append("- An episode ends early only if the simulation diverges.")
        return "\n".join(lines)
    each = (_height_limit(task, made), _angle_limit(made), _state_limit(made))
    limits = [limit for limit in each if limit]
    if limits:
        lines.append(
            f"- An episode ends early, and the rest of it is lost, once {' or '.join(limits)}, or "
            "if the simulation diverges. A robot that starts close to a limit is easily beyond it."
        )
    else:
        lines.append("- An episode ends early once the robot is not healthy.")
    return "\n".join(lines)


def _height_limit(task: Task, made: Any) -> str:
    limits = getattr(made, "_healthy_z_range", None)
    if limits is None:
        return ""
    other = _second(task)
    said = []
    for side, (limit, word) in enumerate(zip(limits, ("lower", "higher"), strict=True)):
        if not math.isfinite(limit):
            continue
        if other is None or other._healthy_z_range[side] == limit:
            said.append(f"{word} than {limit:g} m")
            continue
        # A number would tell how tall the reference robot is.
        shares = [one._healthy_z_range[side] / _start_height(one) for one in (made, other)]
        same = math.isclose(*shares, rel_tol=1e-6)
        height = f"{shares[0]:.3g} times its height at the start" if same else "a limit"
        said.append(f"{word} than {height}")
    return f"the torso is {' or '.join(said)}" if said else ""


def _angle_limit(made: Any) -> str:
    tilt = getattr(made, "_healthy_tilt", None)
    if tilt is not None:
        return f"it leans by more than {math.degrees(tilt):.0f} degrees"
    limits = getattr(made, "_healthy_angle_range", None)
    if limits is None or not all(map(math.isfinite, limits)):
        return ""
    return f"its angle leaves {limits[0]:g} to {limits[1]:g} rad"


def _state_limit(made: Any) -> str:
    limits = getattr(made, "_healthy_state_range", None)
    if limits is None or not all(map(math.isfinite, limits)):
        return ""
    return f"another angle or any velocity leaves {limits[0]:g} to {limits[1]:g} (rad, m/s, rad/s)"


def _environment(task: Task, parameters: Sequence[float]) -> Any:
    from robomore.envs.robots import environment_class

    return environment_class(task)(task, parameters, lambda self, speed, action: (0.0, {}))


def _second(task: Task) -> Any:
    """Return the environment of a second morphology, `None` if there is no valid one nearby."""
    from robomore.errors import InvalidMorphology

    for scale in (1.05, 0.95, 1.02):
        values = [
            (p.reference + 1 if p.reference < p.high else p.reference - 1)
            if p.whole
            else min(max(scale * p.reference, p.low), p.high)
            for p in task.parameters
        ]
        try:
            return _environment(task, task.check(values))
        except InvalidMorphology:
            continue
    return None


def _start_height(made: Any) -> float:
    """Return the height of the torso at the start, in m."""
    return float(made.batch_root(made.init_qpos[None])[0, 1])


def volume_line(task: Task, morphology: Morphology) -> str:
    """Return the volume of a morphology by part, the largest first."""
    shapes = task.solids(dict(zip(task.names, morphology.parameters, strict=True)))
    total = sum(shape.volume for shape in shapes)
    parts = []
    for shape in sorted(shapes, key=lambda one: -one.volume):
        share = f"{100 * shape.volume / total:.0f} %"
        if isinstance(shape, Capsule):
            count = f"{shape.count} capsules" if shape.count > 1 else "capsule"
            size = f"radius {shape.radius:.3g} m, length {shape.length:.3g} m"
        else:
            count, size = "ball", f"radius {shape.radius:.3g} m"
        parts.append(f"{share} {count} ({size})")
    return "Volume by part: " + ", ".join(parts)
