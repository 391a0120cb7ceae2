"""One episode as data for a browser: poses of every body, contacts, torques and the way.

Positions are kept to a tenth of a millimetre along the way and to a 30,000th of the robot's size
within it, so that a page with a dozen episodes stays below a few megabytes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.vector_env import VectorEnv
from robomore.rendering.packing import changes, pack
from robomore.rendering.recording import Act
from robomore.rendering.shapes import moving_bodies, shapes
from robomore.tasks import Task

Array = NDArray[np.float64]

_FRAMES_PER_SECOND = 30
_WAY = 1e-4
"""In m: the root's way is kept in steps of this."""
_MOST_CONTACTS = 8
"""In one frame: those of the largest force."""


def packed_replay(task: Task, parameters: tuple[float, ...], act: Act, title: str) -> bytes:
    """Roll a policy out for one episode; returns it packed (`robomore.rendering.packing`).

    Args:
        task: what the robot is for.
        parameters: of its morphology, in the task's order.
        act: the policy.
        title: for people.

    Raises:
        InvalidMorphology: the task refuses the parameters, or MuJoCo the model.
        UnstableSimulation: the simulation diverges.
        ValueError: the policy was trained for another robot.
    """
    env = VectorEnv(task, parameters, 1, auto_reset=False)
    observation = env.reset_one(0, seed=0)[None]
    data = env.data[0]
    mujoco.mj_forward(env.model, data)
    dt = float(env.environment.dt)
    stride = max(1, round(1 / (_FRAMES_PER_SECOND * dt)))
    film = _Film(env.model)
    film.expose(data)
    roots, fell = [env.root_positions[0]], False
    for step in range(1, task.episode_steps + 1):
        transition = env.step(act(observation))
        observation = transition.final_observation
        roots.append(env.root_positions[0])
        fell = bool(transition.terminated[0])
        if step % stride == 0:
            film.expose(data)
        if fell or transition.truncated[0]:
            break
    path = np.array(roots)
    facts = {
        "title": title,
        "dt": dt * stride,
        "seconds": (len(path) - 1) * dt,
        "distance": float(path[-1, 0] - path[0, 0]),
        "height": float(path[:, 1].max()),
        "fell": fell,
    }
    return pack(facts | shapes(env.model) | film.developed())


@dataclass
class _Film:
    """Collects frames of a simulation."""

    model: mujoco.MjModel
    positions: list[Array] = field(default_factory=list)
    turns: list[Array] = field(default_factory=list)
    torques: list[Array] = field(default_factory=list)
    contacts: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._bodies = moving_bodies(self.model)

    def expose(self, data: mujoco.MjData) -> None:
        """Take one frame."""
        self.positions.append(data.xpos[self._bodies].copy())
        turn = data.xquat[self._bodies].copy()
        if self.turns:  # The same turn has two quaternions; smooth ones can be interpolated.
            turn *= np.where((turn * self.turns[-1]).sum(axis=1) < 0, -1.0, 1.0)[:, None]
        self.turns.append(turn)
        self.torques.append(data.actuator_force * self.model.actuator_gear[:, 0])
        self.contacts.append(_forces(self.model, data))

    def developed(self) -> dict[str, Any]:
        """Return all frames, for `pack`. Axes of arrays: body, number, frame."""
        positions = np.array(self.positions).transpose(1, 2, 0)
        root = np.round(positions[0] / _WAY)
        within = positions - root * _WAY
        reach = max(float(np.abs(within).max()), 1e-6)
        turns = np.array(self.turns).transpose(1, 2, 0)
        torques = np.array(self.torques).T
        most = max(float(np.abs(torques).max(initial=0.0)), 1e-9)
        points = np.concatenate(self.contacts) if self.contacts else np.zeros((0, 6))
        counts = np.array([len(one) for one in self.contacts], np.uint8)
        way = np.repeat(root.T * _WAY, counts, axis=0)
        force = max(float(np.abs(points[:, 3:]).max(initial=0.0)), 1e-9)
        spread = max(float(np.abs(points[:, :3] - way).max(initial=0.0)), 1e-6)
        return {
            "frames": positions.shape[2],
            "root": changes(root, "i4"),
            "way": _WAY,
            "positions": changes(np.round(within / reach * 30_000), "i2"),
            "reach": reach / 30_000,
            "turns": changes(np.round(turns * 30_000), "i2"),
            "actuators": _actuators(self.model, self._bodies),
            "torques": np.round(torques / most * 127).astype(np.int8),
            "most_torque": most,
            "contacts": counts,
            "contact_points": np.round((points[:, :3] - way) / spread * 30_000).astype("<i2"),
            "contact_spread": spread / 30_000,
            "contact_forces": np.round(points[:, 3:] / force * 30_000).astype("<i2"),
            "most_force": force / 30_000,
            "weight": float(self.model.body_mass[1:].sum() * abs(self.model.opt.gravity[2])),
        }


def _forces(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return contacts (n, 6): position in m and the force on the robot in N, strongest first."""
    found = []
    force = np.zeros(6)
    for index in range(data.ncon):
        contact = data.contact[index]
        mujoco.mj_contactForce(model, data, index, force)
        if force[0] <= 0:
            continue
        first, second = (model.body_weldid[model.geom_bodyid[geom]] for geom in contact.geom)
        # MuJoCo's force acts on the second geom; of two of the robot either will do.
        sign = 1.0 if second or not first else -1.0
        found.append([*contact.pos, *(sign * contact.frame.reshape(3, 3).T @ force[:3])])
    points = np.array(found, np.float64).reshape(-1, 6)
    order = np.argsort(-np.linalg.norm(points[:, 3:], axis=1), kind="stable")
    return np.asarray(points[order[:_MOST_CONTACTS]])


def _actuators(model: mujoco.MjModel, bodies: list[int]) -> list[dict[str, Any]]:
    """Return where each motor sits; one that drives no single joint has no `body`."""
    found: list[dict[str, Any]] = []
    for actuator in range(model.nu):
        one: dict[str, Any] = {"name": model.actuator(actuator).name or f"motor {actuator + 1}"}
        joint = int(model.actuator_trnid[actuator, 0])
        if model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT:
            body = int(model.jnt_bodyid[joint])
            if body in bodies:
                one |= {
                    "body": bodies.index(body),
                    "pos": model.jnt_pos[joint].tolist(),
                    "axis": model.jnt_axis[joint].tolist(),
                }
        found.append(one)
    return found
