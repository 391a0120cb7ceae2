"""How finely the physics is simulated within a control step, which stays what it is."""

from __future__ import annotations

import mujoco

from robomore.envs.robots.base import RobotEnvironment


def divide_timestep(environment: RobotEnvironment, by: int) -> None:
    """Simulate in steps of one `by`-th of what they were."""
    environment.model.opt.timestep /= by
    environment.frame_skip *= by


def without_rk4(environment: RobotEnvironment) -> None:
    """Replace RK4, if the task has it, by implicitfast at half the timestep, for half the work.

    RK4 evaluates all forces four times in a timestep, implicitfast once. At RK4's own timestep it
    is too coarse: a human Ant that runs 65 m with RK4 then runs 10 m, and at half of it 65 m
    (`robomore.audit.integrator`).
    """
    option = environment.model.opt
    if option.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        divide_timestep(environment, 2)
