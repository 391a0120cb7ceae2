"""How far the same policy goes with RK4 and with implicitfast, at finer and finer timesteps.

    python benchmarks/integrators.py [--robots ant hopper walker swimmer] [--seed 0]
        [--steps 153600] [--trained-without-rk4]

Physics is what is left when the timestep goes to zero. Where an integrator agrees with that, it is
fine enough; where it does not, its policies are of another robot. The policies are trained with
RK4, and measured in ten episodes, the same for all.
"""

from __future__ import annotations

import argparse

import numpy as np

from curves import EPISODES, HUMAN_FITNESS, open_trainer
from robomore.audit.variant import Variant, VariedEnv
from robomore.evaluation.measure import choose
from robomore.identity import derive_seed
from robomore.tasks import get_task
from robomore.training.loop import TrainingRun
from robomore.training.policy import MLPPolicy
from robomore.training.rollout import rollout
from robomore.types import TrainerSettings

DIVISIONS = (1, 2, 4, 8)
"""Parts of the task's own timestep."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    robots = [robot for robot in HUMAN_FITNESS if robot != "half-cheetah"]
    parser.add_argument("--robots", nargs="*", default=robots, choices=robots)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=153_600)
    parser.add_argument("--trained-without-rk4", action="store_true", help="as is the default")
    given = parser.parse_args()
    trainer = TrainerSettings("crossq", {"replace_rk4": given.trained_without_rk4})
    for robot in given.robots:
        policy = trained(robot, trainer, given.seed, given.steps)
        print(f"\n{robot}, seed {given.seed}, {given.steps} steps; m (fewest, most)")
        for integrator in ("RK4", "IMPLICITFAST"):
            found = [distances(robot, policy, integrator, division) for division in DIVISIONS]
            cells = [f"{one.mean():.1f} ({one.min():.1f}, {one.max():.1f})" for one in found]
            print(f"{integrator:14}" + "".join(f"{cell:>24}" for cell in cells), flush=True)


def trained(robot: str, trainer: TrainerSettings, seed: int, steps: int) -> MLPPolicy:
    """Return the policy of the human design that an evaluation would take."""
    task = get_task(robot)
    algorithm, environment = open_trainer(task, task.reference, trainer)
    seed = derive_seed(seed, robot, "human")
    run = TrainingRun(algorithm, algorithm.settings, environment, seed)
    while run.steps < steps:
        run.advance()
    return choose(task, task.reference, run.policies(), seed)


def distances(
    robot: str, policy: MLPPolicy, integrator: str, division: int
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return how far the policy goes in each episode, in m."""
    task = get_task(robot)
    variant = Variant(integrator=integrator, timestep_division=division)
    simulations = VariedEnv(task, task.reference, EPISODES, variant)
    rollout(policy, simulations, range(EPISODES))
    return np.array([simulations.motions[seed].distance for seed in range(EPISODES)])


if __name__ == "__main__":
    main()
