"""Our algorithms on probes with known values, and on a small control task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from probes import SAC_SETTINGS, SETTINGS, Cart, Ending, Probe

from robomore.errors import InputError, TrainingDiverged
from robomore.training import networks, perceptron
from robomore.training.crossq import CrossQ
from robomore.training.loop import Run
from robomore.training.sac import SAC
from robomore.training.settings import CrossQSettings, SACSettings


@dataclass(frozen=True)
class Algorithm:
    """An algorithm, and how weights and biases are read off what it has learnt.

    Attributes:
        make: its class.
        settings: for probes.
        policy: of a run and the layers' sizes.
        critics: of a run and the layers' sizes, one for each critic.
    """

    make: Callable[[Any], Any]
    settings: CrossQSettings | SACSettings
    policy: Callable[[Run, networks.Sizes], networks.Folded]
    critics: Callable[[Run, networks.Sizes], list[networks.Folded]]


def _folded(parameters: Any, moments: Any, sizes: networks.Sizes) -> networks.Folded:
    return networks.fold(networks.layers(parameters, sizes), networks.moments(moments, sizes))


CROSSQ = Algorithm(
    CrossQ,
    SETTINGS,
    lambda run, sizes: _folded(*run.learner.policy[:2], sizes),
    lambda run, sizes: [
        _folded(*each, sizes) for each in zip(*run.learner.critics[:2], strict=True)
    ],
)
PLAIN = Algorithm(
    SAC,
    SAC_SETTINGS,
    lambda run, sizes: perceptron.layers(run.learner.policy.parameters, sizes),
    lambda run, sizes: [perceptron.layers(each, sizes) for each in run.learner.critics.parameters],
)


@pytest.fixture(params=[CROSSQ, PLAIN], ids=["crossq", "sac"])
def algorithm(request: pytest.FixtureRequest) -> Any:
    return request.param


def trained(
    algorithm: Algorithm,
    probe: Any,
    steps: int,
    seed: int = 1,
    entropy_weight: float = 1e-4,
    policy_ema_fraction: float = 0.0,
) -> Run:
    # What the compiled step does not read is set past its settings: compiling takes long.
    settings = replace(algorithm.settings, policy_ema_fraction=policy_ema_fraction)
    run = Run(algorithm.make(algorithm.settings), settings, probe, seed)
    policy = run.learner.policy._replace(log_entropy_weight=np.log(np.float32(entropy_weight)))
    run.learner = run.learner._replace(policy=policy)
    run.observation = probe.reset(seed)
    while run.steps < steps:
        run.advance()
    return run


def values(
    algorithm: Algorithm, run: Run, observation: list[float], action: float
) -> NDArray[np.float32]:
    """Values that each critic gives one state and action, as it does when it is not training."""
    inputs: Any = np.array([[*observation, action]], np.float32)
    critics = algorithm.critics(run, (3, *algorithm.settings.hidden, 1))
    return np.array([networks.apply(critic, inputs).item() for critic in critics])


def test_the_value_of_one_step_is_its_reward(algorithm: Algorithm) -> None:
    run = trained(algorithm, Probe(lambda elapsed, bit, action: 2.0 * bit - 1), 8_000)
    assert values(algorithm, run, [0, 1], 0.3) == pytest.approx(1, abs=0.1)
    assert values(algorithm, run, [0, 0], 0.3) == pytest.approx(-1, abs=0.1)


def test_the_value_of_an_earlier_step_is_discounted(algorithm: Algorithm) -> None:
    run = trained(algorithm, Probe(lambda elapsed, bit, action: elapsed == 1, length=2), 6_000)
    assert values(algorithm, run, [0.5, 1], 0.0) == pytest.approx(1, abs=0.1)
    assert values(algorithm, run, [0, 1], 0.0) == pytest.approx(
        algorithm.settings.discount, abs=0.1
    )


@pytest.mark.parametrize(("ending", "value"), [((True, False), 1.0), ((False, True), 10.0)])
def test_truncation_bootstraps_and_termination_does_not(
    algorithm: Algorithm, ending: Ending, value: float
) -> None:
    # The last observation looks like the first, so a truncated episode goes on for ever.
    class Loop(Probe):
        def _observation(self) -> NDArray[np.float64]:
            return np.stack([np.zeros(self.num_envs), self.bit], axis=1)

    run = trained(algorithm, Loop(lambda elapsed, bit, action: np.ones(4), ending=ending), 4_000)
    assert values(algorithm, run, [0, 1], 0.0) == pytest.approx(value, rel=0.15)


def test_the_policy_picks_what_is_rewarded(algorithm: Algorithm) -> None:
    wanted = {0: -0.5, 1: 0.5}

    def reward(elapsed: Any, bit: Any, action: NDArray[Any]) -> NDArray[Any]:
        return -np.square(action[:, 0] - np.where(bit, wanted[1], wanted[0]))

    policy = trained(
        algorithm, Probe(reward), 6_000, entropy_weight=0.1, policy_ema_fraction=0.3
    ).policies()[-1]
    for bit, best in wanted.items():
        assert policy.act(np.array([[0.0, bit]])) == pytest.approx(best, abs=0.15)


def test_a_control_task_is_learnt(algorithm: Algorithm) -> None:
    policy = trained(algorithm, Cart(), 8_000).policies()[-1]
    cart = Cart()
    observation = cart.reset(seed=7)
    rewards = []
    for _ in range(cart.length):
        transition = cart.step(policy.act(observation))
        observation = transition.observation
        rewards.append(transition.reward)
    # Doing nothing gives about -6 a step on average, the best controller about -0.13.
    assert np.mean(rewards) > -0.25


def test_the_policy_is_that_of_the_network_in_jax(algorithm: Algorithm) -> None:
    run = trained(algorithm, Cart(), 512)
    observations = np.random.default_rng(0).normal(size=(50, 2)).astype(np.float32)
    network = algorithm.policy(run, (2, *algorithm.settings.hidden, 2))
    given: Any = observations
    heads = networks.apply(network, given)
    assert run.policies()[-1].act(observations) == pytest.approx(np.tanh(heads[:, :1]), abs=1e-5)


def test_a_reward_too_large_for_its_numbers_is_said_so(algorithm: Algorithm) -> None:
    with pytest.raises(TrainingDiverged, match="no longer a finite number"):
        trained(algorithm, Probe(lambda elapsed, bit, action: np.full(4, 1e30)), 512)


def test_a_round_that_the_simulations_do_not_divide_is_refused(algorithm: Algorithm) -> None:
    with pytest.raises(InputError, match="divide"):
        algorithm.make(replace(algorithm.settings, train_freq=10)).train(Cart(), 1_000, seed=1)
    with pytest.raises(InputError, match="at least one"):
        algorithm.make(algorithm.settings).train(Cart(), 10, seed=1)
