"""Learning curves of our CrossQ and of SBX's, at the same settings in the same environments.

    python benchmarks/against_sbx.py [--robots half-cheetah hopper] [--seeds 3] [--steps 51200]

Both have SBX's defaults but for the networks and the batch (128), 16 environments, and 16 gradient
steps every 128 control steps; rewards are as they are, and what is tuned for a robot is set back.
One setting is not alike: Adam's decay of the mean gradient of the entropy's weight, which is 0.5
here and in SBX 0.9, the optimiser's default. What is compared is learning, so the curves should lie
within each other's spread over seeds; what it costs is `update.py`. Needs SBX: pip install sbx-rl
"""

from __future__ import annotations

import argparse
from statistics import median
from typing import Any

import numpy as np

from curves import EPISODES, Course, follow, open_trainer
from robomore.evaluation.measure import measure
from robomore.identity import derive_seed
from robomore.tasks import get_task
from robomore.training import networks
from robomore.training.loop import deterministic
from robomore.training.policy import MLPPolicy
from robomore.training.threads import use_one_thread
from robomore.types import TrainerSettings

SAME: dict[str, Any] = {
    "net_arch": [128, 128],
    "batch_size": 128,
    "train_freq": 8,
    "gradient_steps": 16,
    "learning_starts": 5_000,
    "buffer_size": 1_000_000,
    "n_critics": 2,
    "min_q_weight": 1.0,
    "num_bins": 0,
    "n_steps": 1,
    "normalize_rewards": False,
    "init_alpha": 1.0,
    "actor_lr": 1e-3,
    "critic_lr": 1e-3,
    "alpha_lr": 1e-3,
    "policy_delay": 3,
    "observed": None,
    "max_noise_repeat": 1,
    "deterministic_env_fraction": 0.0,
    "policy_ema_fraction": 0.0,
    "num_eval_checkpoints": 1,
    "gamma": 0.99,
}
"""Options of ours that make it what SBX's is. Whatever may be tuned for a robot is among them."""
SHARED = (
    *("learning_starts", "batch_size", "buffer_size", "train_freq", "gradient_steps"),
    *("policy_delay", "gamma"),
)
"""Those of them that SBX calls the same."""
EVERY = 12_800


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robots", nargs="*", default=["half-cheetah", "hopper"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=51_200)
    given = parser.parse_args()
    use_one_thread()
    for robot in given.robots:
        ours, theirs = [], []
        for seed in range(given.seeds):
            human = get_task(robot).reference
            course = Course(
                robot, "human", human, seed, TrainerSettings("crossq", SAME), given.steps, EVERY
            )
            ours.append([mark.fitness for mark in follow(course)])
            theirs.append(sbx_curve(robot, seed, given.steps))
        print(f"\n{robot}, human design: fitness in m, median and range over {given.seeds} seeds")
        print(f"{'steps':>8}{'RoboMoRe':>26}{'SBX':>26}")
        for number in range(len(ours[0])):
            columns = "".join(
                f"{median(values):>10.2f} ({min(values):>6.2f}-{max(values):>6.2f})"
                for side in (ours, theirs)
                for values in [[curve[number] for curve in side]]
            )
            print(f"{(number + 1) * EVERY:>8}{columns}", flush=True)


def sbx_curve(robot: str, seed: int, steps: int) -> list[float]:
    """Return the fitness of SBX's policy every `EVERY` steps."""
    import sbx

    from robomore.training.sb3 import LibraryEnvironment

    task = get_task(robot)
    _, environment = open_trainer(task, task.reference, TrainerSettings("crossq", SAME))
    model = sbx.CrossQ(
        "MlpPolicy",
        LibraryEnvironment(environment, derive_seed(seed, robot, "sbx")),
        learning_rate=SAME["critic_lr"],
        policy_kwargs={"net_arch": SAME["net_arch"]},
        seed=seed,
        **{name: SAME[name] for name in SHARED},
    )
    found = []
    for number in range(steps // EVERY):
        model.learn(EVERY, reset_num_timesteps=not number)
        policy = policy_of(model)
        found.append(measure(task, task.reference, policy, EPISODES, seed).fitness)
    return found


def policy_of(model: Any) -> MLPPolicy:
    """Return SBX's deterministic policy as one of ours."""
    state = model.policy.actor_state
    count = sum(name.startswith("BatchRenorm") for name in state.params)
    layers, moments = [], []
    for i in range(count):
        norm, seen = state.params[f"BatchRenorm_{i}"], state.batch_stats[f"BatchRenorm_{i}"]
        dense = state.params[f"Dense_{i}"]
        kernel, bias = np.asarray(dense["kernel"]), np.asarray(dense["bias"])
        if i == count - 1:  # Ours has a head for the deviation beside that for the mean.
            kernel, bias = np.tile(kernel, 2), np.tile(bias, 2)
        layers.append(networks.Layer(norm["scale"], norm["bias"], kernel, bias))
        moments.append(networks.Moments(seen["mean"], seen["var"]))
    folded = networks.fold(layers, moments)
    return deterministic([(np.asarray(weight), np.asarray(bias)) for weight, bias in folded])


if __name__ == "__main__":
    main()
