"""The environment of a robot of one's own: whatever an MJCF or URDF file describes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv
from gymnasium.spaces import Box
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from robomore.envs.control_map import ControlMap
from robomore.envs.rest_pose import rest_pose
from robomore.envs.robots.base import Array, RobotEnvironment
from robomore.envs.root import SIMPLE_JOINTS, find_root
from robomore.errors import InputError

_CONTACT = "contact_"


class JointState(NamedTuple):
    """What a joint does now.

    Attributes:
        angle: in rad, or a position in m.
        velocity: in rad/s, or m/s.
        torque: of its motors, in N·m, or a force in N.
    """

    angle: float
    velocity: float
    torque: float


class OwnRobotEnv(MujocoEnv, EzPickle):
    """A robot with the parts that its file has; everything else is an option.

    A root that moves, freely or in the plane of x and z, starts in its rest pose and faces +x, its
    lowest point just above the floor. An episode ends once it tilts or leaves the healthy heights.
    """

    def __init__(
        self,
        frame_skip: int = 10,
        home: Mapping[str, float] | None = None,
        upright: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        healthy_tilt: float | None = 1.0,
        healthy_height: Sequence[float] | None = (0.5, 2.0),
        reset_noise: float = 0.05,
        reach: float = 1.0,
        sensors: Sequence[str] = (),
        tip: str = "",
        render_mode: str | None = None,
    ) -> None:
        """Build the robot.

        Args:
            frame_skip: steps of MuJoCo in a control step.
            home: angle (rad) or position (m) of joints at rest, by name; others rest at 0.
            upright: orientation of a free root at rest, as a quaternion w, x, y, z.
            healthy_tilt: largest angle in rad between the root's upward direction and that at rest;
                `None` for any.
            healthy_height: least and greatest height in multiples of that at rest, `None` for any.
            reset_noise: up to so much (rad, m and rad/s, m/s) is added to each joint at the start.
            reach: fraction of each control range, on either side of the rest pose, that is used.
            sensors: names of the sensors that are observed.
            tip: name of the site or link whose motion counts for a robot that is fixed to the
                world; empty for the last link.
            render_mode: as in Gymnasium.
        """
        self._home = dict(home or {})
        self._upright = tuple(float(number) for number in upright)
        self._reach, self._reset_noise_scale, self._tip = reach, reset_noise, tip
        # The file is never read: the model comes from `_initialize_simulation`.
        self.metadata = {"render_modes": ["human", "rgb_array", "depth_array"]}
        MujocoEnv.__init__(self, "ant.xml", frame_skip, None, render_mode)
        self.metadata["render_fps"] = round(1 / self.dt)
        model = self.model
        self._root = find_root(model)
        self._free = self._root.base == "free"
        self._inner = np.ones(model.nq, np.bool_)
        self._seen_qpos, self._seen_qvel = self._inner.copy(), np.ones(model.nv, np.bool_)
        for joint in self._root.joints:
            start = int(model.jnt_qposadr[joint])
            self._inner[start : start + (7 if self._free else 1)] = False
        if self._free:
            self._seen_qpos, self._seen_qvel[:6] = self._inner, False
        elif self._root.moves:
            self._seen_qpos[self._root.along] = False
        self._turn = _matrices(np.array([self._upright]))[0]
        self._joints = {
            model.joint(j).name: _places(model, j)
            for j in range(model.njnt)
            if int(model.jnt_type[j]) in SIMPLE_JOINTS
        }
        self._sensors = {model.sensor(s).name: _slice(model, s) for s in range(model.nsensor)}
        self._contacts = {
            name.removeprefix(_CONTACT): place
            for name, place in self._sensors.items()
            if name.startswith(_CONTACT)
        }
        self._flags = np.array([start for start, _ in self._contacts.values()], dtype=np.intp)
        if unknown := [name for name in sensors if name not in self._sensors]:
            raise InputError(f"the robot has no sensor {unknown[0]!r}, which is to be observed")
        self._shown = np.array(
            [i for name in sensors for i in range(*self._sensors[name])], dtype=np.intp
        )
        self.init_qpos = rest_pose(model, self._home, self._upright)
        self._rest_height = self._height(self.init_qpos)
        low, high = healthy_height or (-np.inf, np.inf)
        unit = self._rest_height if healthy_height else 1.0
        self._healthy_z_range = (low * unit, high * unit)
        self._healthy_tilt = healthy_tilt
        self._terminate_when_unhealthy = self._root.moves
        self._map = ControlMap(model, self.init_qpos, reach)
        size = len(self._observation(self.state_vector()[None], self._observed_now()[None])[0])
        self.observation_space = Box(-np.inf, np.inf, (size,), np.float64)

    def joint(self, name: str) -> JointState:
        """Return angle (rad), velocity (rad/s) and motor torque (N·m) of a hinge.

        A sliding joint has position (m), velocity (m/s) and force (N) in their places.
        """
        position, velocity = self._known(self._joints, name, "joint")
        data = self.data
        return JointState(
            float(data.qpos[position]),
            float(data.qvel[velocity]),
            float(data.qfrc_actuator[velocity]),
        )

    def home_angle(self, name: str) -> float:
        """Return the angle of a joint at rest, in rad (m for a sliding joint)."""
        return float(self.init_qpos[self._known(self._joints, name, "joint")[0]])

    def contact_force(self, name: str) -> float:
        """Return the size of the force between the end of a limb and what it touches, in N."""
        start, _ = self._known(self._contacts, name, "contact sensor")
        return float(np.linalg.norm(self.data.sensordata[start + 1 : start + 4]))

    def touches(self, name: str) -> bool:
        """Return whether the end of a limb touches something."""
        return bool(self.data.sensordata[self._known(self._contacts, name, "contact sensor")[0]])

    def sensor(self, name: str) -> Array:
        """Return the numbers of a sensor, in its own units."""
        start, stop = self._known(self._sensors, name, "sensor")
        values: Array = np.array(self.data.sensordata[start:stop])
        return values

    @property
    def root_height(self) -> float:
        """Height of a root that moves above the floor, in m."""
        return self._height(np.array(self.data.qpos))

    @property
    def rest_height(self) -> float:
        """Height of a root that moves at rest, in m."""
        return self._rest_height

    @property
    def tilt(self) -> float:
        """Angle between the upward direction of a root that moves and the vertical, in rad."""
        up = float(self._vertical(np.array(self.data.qpos)[None])[0])
        return float(np.arccos(min(1.0, max(-1.0, up))))

    @property
    def heading(self) -> float:
        """Angle of a free root about the vertical, in rad; 0 faces +x, left is positive."""
        if not self._free:
            return 0.0
        turned = _matrices(self.data.qpos[None, 3:7])[0] @ self._turn.T
        return float(np.arctan2(turned[1, 0], turned[0, 0]))

    @property
    def target_distance(self) -> float:
        """Distance between the tip and the target, in m, if the task has one."""
        return float(np.linalg.norm(self.sensor("target")))

    @property
    def has_target(self) -> bool:
        """Whether the task has a target."""
        return "target" in self._sensors

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names that `joint` takes."""
        return tuple(self._joints)

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Names that `contact_force` and `touches` take."""
        return tuple(self._contacts)

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """Names that `sensor` takes."""
        return tuple(self._sensors)

    @property
    def is_healthy(self) -> bool:
        """Whether the root is neither tilted nor at an unhealthy height."""
        return bool(self._healthy(np.array(self.data.qpos)[None])[0])

    def step(self, action: NDArray[Any]) -> tuple[Array, Any, bool, bool, dict[str, Any]]:
        """Do one control step, as Gymnasium says."""
        before = self._position()
        self.do_simulation(action, self.frame_skip)
        x_velocity = float((self._position() - before) / self.dt)
        reward, terms = self._get_rew(x_velocity, action)
        terminated = self._terminate_when_unhealthy and not self.is_healthy
        if self.render_mode == "human":
            self.render()  # type: ignore[no-untyped-call]
        return self._get_obs(), reward, terminated, False, {"x_velocity": x_velocity, **terms}

    def reset_model(self) -> Array:
        """Start an episode in the rest pose with some noise; returns the observation."""
        noise, random = self._reset_noise_scale, self.np_random
        qpos, qvel = np.array(self.init_qpos), np.zeros(self.model.nv)
        qpos[self._inner] += random.uniform(-noise, noise, int(self._inner.sum()))
        qvel += random.uniform(-noise, noise, len(qvel))
        rest = self._map.rest
        self.data.ctrl[:] = rest
        # A motor with dynamics of its own starts where its control is.
        filtered = self.model.actuator_actadr >= 0
        if self.model.na:
            self.data.act[self.model.actuator_actadr[filtered]] = rest[filtered]
        self.set_state(qpos, qvel)  # type: ignore[no-untyped-call]
        return self._get_obs()

    def _get_rew(self, x_velocity: float, action: Array) -> tuple[float, Mapping[str, float]]:
        raise NotImplementedError

    def _get_obs(self) -> Array:
        observation: Array
        (observation,) = self._observation(self.state_vector()[None], self._observed_now()[None])
        return observation

    def _observed_now(self) -> Array:
        return np.concatenate((self.data.sensordata, self.data.ctrl))

    def _observation(self, state: Array, observed: Array) -> Array:
        """Return observations (n, size) of states (n, nq + nv) and sensors with controls (n, …)."""
        nq, sensors = self.model.nq, self.model.nsensordata
        qpos, qvel = state[:, :nq], state[:, nq:]
        parts = []
        if self._free:
            turned = _matrices(qpos[:, 3:7]) @ self._turn.T
            parts += [
                qpos[:, 2:3],
                turned[:, 2, :],  # the vertical, as the root sees it
                turned[:, 0, :],  # the direction of the course, likewise
                np.einsum("nij,ni->nj", turned, qvel[:, :3]),
                qvel[:, 3:6] @ self._turn.T,
            ]
        parts += [
            (qpos - self.init_qpos)[:, self._seen_qpos],
            qvel[:, self._seen_qvel],
            self._map.actions(observed[:, sensors:]),
            np.minimum(observed[:, self._flags], 1.0),
            observed[:, self._shown],
        ]
        return np.concatenate(parts, axis=1)

    def _healthy(self, qpos: Array) -> NDArray[np.bool_]:
        if not self._root.moves:
            return np.ones(len(qpos), np.bool_)
        low, high = self._healthy_z_range
        height = self._root.position(qpos)[:, 1]
        healthy: NDArray[np.bool_] = (low <= height) & (height <= high)
        if self._healthy_tilt is not None:
            healthy &= self._vertical(qpos) >= np.cos(self._healthy_tilt)
        return healthy

    def _vertical(self, qpos: Array) -> Array:
        """Return cosines (n,) of the angle by which the root leans, for positions (n, nq)."""
        if self._free:
            return np.asarray((_matrices(qpos[:, 3:7]) @ self._turn.T)[:, 2, 2])
        if self._root.lean is None:
            return np.ones(len(qpos))
        return np.asarray(np.cos(qpos[:, self._root.lean] - self.init_qpos[self._root.lean]))

    def _height(self, qpos: Array) -> float:
        return float(self._root.position(qpos[None])[0, 1]) if self._root.moves else 0.0

    def _position(self) -> float:
        if self._root.moves:
            return float(self.data.qpos[self._root.along])
        return float(self._place_of_tip(self.data)[0])

    def _place_of_tip(self, data: mujoco.MjData) -> Array:
        """Return a live view (3,) of where the tip is, or else the last link."""
        sites = [self.model.site(number).name for number in range(self.model.nsite)]
        place: Array = data.xpos[-1]
        if self._tip:
            place = data.site(self._tip).xpos if self._tip in sites else data.body(self._tip).xpos
        return place

    def _known(self, places: Mapping[str, Any], name: str, what: str) -> Any:
        if name not in places:
            known = ", ".join(places) or "none"
            raise KeyError(f"no {what} is called {name!r}; there are: {known}")
        return places[name]


class OwnRobotEnvironment(RobotEnvironment, OwnRobotEnv):
    """A robot of one's own with free dimensions and a reward from outside."""

    def control_map(self) -> ControlMap:
        return ControlMap(self.model, self.init_qpos, self._reach)

    def position_view(self, data: mujoco.MjData) -> Array | None:
        if self._root.moves:
            return np.asarray(data.qpos)[self._root.along :][:1]
        return self._place_of_tip(data)[:1]

    def observed_views(self, data: mujoco.MjData) -> list[Array]:
        return [data.sensordata, data.ctrl]

    def batch_observation(self, state: Array, observed: Array) -> Array:
        return self._observation(state, observed)

    def batch_healthy(self, state: Array) -> NDArray[np.bool_]:
        return self._healthy(state[:, : self.model.nq])

    def batch_root(self, qpos: Array) -> Array:
        return self._root.position(qpos)


def _places(model: mujoco.MjModel, joint: int) -> tuple[int, int]:
    return int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])


def _slice(model: mujoco.MjModel, sensor: int) -> tuple[int, int]:
    start = int(model.sensor_adr[sensor])
    return start, start + int(model.sensor_dim[sensor])


def _matrices(quaternions: Array) -> Array:
    """Return rotation matrices (n, 3, 3) of unit quaternions (n, 4) w, x, y, z."""
    w, x, y, z = quaternions.T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(rows), 2, 0)
