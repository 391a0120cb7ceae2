"""Does a fitness fit the robot: are its parts there, and is there any way left to its target?"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.recorder import place_of
from robomore.errors import InputError
from robomore.tasks.fitness import Fitness


def refuse_goal(
    id: str, fitness: Fitness, model: mujoco.MjModel, qpos: NDArray[np.float64]
) -> None:
    """Refuse a fitness whose part the robot lacks, or whose target is reached at rest.

    Args:
        id: of the task, for the message.
        fitness: of the task.
        model: of the reference robot.
        qpos: (nq,) its pose at rest.

    Raises:
        InputError: naming the parts that there are, or the distance.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    for term in fitness.terms:
        part = term.options.get("part")
        try:
            at = place_of(model, data, part)() if part else data.xpos[1]
        except InputError as error:
            raise InputError(f"{id}: the fitness {term.name!r}: {error}") from None
        if term.name != "target-reached":
            continue
        target, radius = term.options["target"], term.options["radius"]
        away = float(np.linalg.norm(at[: len(target)] - target))
        if away <= radius:
            raise InputError(
                f"{id}: the fitness 'target-reached' has radius = {radius:g} m, and the robot "
                f"rests {away:.3g} m from its target, so that it need not move; give a smaller "
                "radius, or a target farther away"
            )
