"""Does the robot do the same with another integrator, and with another solver of contacts?"""

from __future__ import annotations

import mujoco

from robomore.audit.retained import NUMERICAL_GAIN, retained
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.envs.compile import compile_model
from robomore.store.audit import Verdict

FAILS_BELOW, WARNS_BELOW = 0.5, 0.7
"""Fractions of the distance that are left. Half-Cheetah's task uses an integrator of first order;
with one of fourth order, two policies of its human design kept 75 and 96 %."""

FIRST_ORDER = Variant(integrator="IMPLICITFAST", timestep_division=2)
"""What RK4 is compared with. At RK4's own timestep it would be the coarser of the two: there a
human Ant that runs 65 m with RK4, at that timestep and at a half to an eighth of it, got 10 m, and
65, 72 and 67 m at a half, a quarter and an eighth."""
FOURTH_ORDER = Variant(integrator="RK4")


def check(subject: Subject) -> Verdict:
    """Change RK4 to implicitfast at half the timestep, or another one to RK4; and the solver."""
    option = compile_model(subject.task, subject.parameters).opt
    fourth_order = option.integrator == mujoco.mjtIntegrator.mjINT_RK4
    other = FIRST_ORDER if fourth_order else FOURTH_ORDER
    finer = " at half the timestep" if fourth_order else ""
    gradient = option.solver == mujoco.mjtSolver.mjSOL_CG
    solver = "NEWTON" if gradient else "CG"
    return retained(
        subject,
        "another integrator and solver",
        {
            f"integrator {other.integrator}{finer}": other,
            f"solver {solver}": Variant(solver=solver),
        },
        fails_below=FAILS_BELOW,
        warns_below=WARNS_BELOW,
        warns_above=NUMERICAL_GAIN,
    )
