"""Where a policy's actions in [-1, 1] go on the control ranges of a robot's motors."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_MARGIN = 0.02
"""A rest pose this close to an end of the range, as a fraction of it, is no middle to move around.
"""


class ControlMap:
    """Maps actions in [-1, 1] onto control ranges: -1 and 1 are the ends, 0 is the rest pose.

    The rest pose of a servo is where it holds the robot's pose at the start. A motor that applies a
    torque rests at 0. Where that lies outside of the range or at its end, 0 is the middle.

    Attributes:
        rest: (motors,) control of the action 0.
        holding: (motors,) control that holds the rest pose, where it lies in the range.
        centred: (motors,) whether `rest` is the middle of the range instead of `holding`.
        is_identity: whether actions are controls as they are.
    """

    def __init__(self, model: mujoco.MjModel, qpos: Array, reach: float = 1.0) -> None:
        """Read the ranges.

        Args:
            model: of the robot.
            qpos: (nq,) its pose at rest.
            reach: fraction of the range on either side of the rest pose that is used.
        """
        limited = model.actuator_ctrllimited.astype(bool)
        low = np.where(limited, model.actuator_ctrlrange[:, 0], -1.0)
        high = np.where(limited, model.actuator_ctrlrange[:, 1], 1.0)
        self.holding: Array = _rest(model, qpos)
        margin = _MARGIN * (high - low)
        inside = (low + margin <= self.holding) & (self.holding <= high - margin)
        self.centred: NDArray[np.bool_] = ~inside
        self.rest: Array = np.where(inside, self.holding, (low + high) / 2)
        self._down: Array = reach * (self.rest - low)
        self._up: Array = reach * (high - self.rest)
        self.is_identity = bool((self.rest == 0).all() and (self._down == 1).all())
        self.is_identity &= bool((self._up == 1).all())

    def controls(self, actions: Array) -> Array:
        """Return the controls (…, motors) of actions (…, motors)."""
        if self.is_identity:
            return actions
        bounded = np.clip(actions, -1.0, 1.0)
        return self.rest + np.where(bounded < 0, self._down, self._up) * bounded

    def actions(self, controls: Array) -> Array:
        """Return the actions (…, motors) that have these controls."""
        if self.is_identity:
            return controls
        away = controls - self.rest
        width = np.where(away < 0, self._down, self._up)
        return np.divide(away, width, out=np.zeros_like(away), where=width > 0)


def _rest(model: mujoco.MjModel, qpos: Array) -> Array:
    """Return the control (motors,) at which each motor applies no force in the pose `qpos`."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    servo = model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE
    servo &= (model.actuator_biasprm[:, 1] != 0) & (model.actuator_gainprm[:, 0] != 0)
    bias = model.actuator_biasprm[:, 0] + model.actuator_biasprm[:, 1] * data.actuator_length
    gain = np.where(servo, model.actuator_gainprm[:, 0], 1.0)
    return np.where(servo, -bias / gain, 0.0)
