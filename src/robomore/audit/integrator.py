"""Does the robot do the same with another integrator, and with another solver of contacts?"""

from __future__ import annotations

import mujoco

from robomore.audit.retained import retained
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.envs.compile import compile_model
from robomore.store.audit import Verdict

FAILS_BELOW, WARNS_BELOW = 0.5, 0.7
"""Fractions of the distance that are left. Half-Cheetah's task uses an integrator of first order;
with one of fourth order, two policies of its human design kept 75 and 96 %."""


def check(subject: Subject) -> Verdict:
    """Change RK4 to implicit-fast, or another one to RK4; and the solver to conjugate gradient."""
    option = compile_model(subject.task, subject.parameters).opt
    fourth_order = option.integrator == mujoco.mjtIntegrator.mjINT_RK4
    integrator = "IMPLICITFAST" if fourth_order else "RK4"
    gradient = option.solver == mujoco.mjtSolver.mjSOL_CG
    solver = "NEWTON" if gradient else "CG"
    return retained(
        subject,
        "another integrator and solver",
        {
            f"integrator {integrator}": Variant(integrator=integrator),
            f"solver {solver}": Variant(solver=solver),
        },
        fails_below=FAILS_BELOW,
        warns_below=WARNS_BELOW,
    )
