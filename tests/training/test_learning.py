"""Our algorithms on probes with known values, and on a small control task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from probes import SAC_SETTINGS, SETTINGS, Cart

from exhaustive import more_of
from robomore.errors import InputError, TrainingDiverged
from robomore.testing.probe_env import ProbeEnv
from robomore.training import networks, perceptron
from robomore.training.crossq import CrossQ
from robomore.training.loop import TrainingRun
from robomore.training.sac import SAC
from robomore.training.settings import CrossQSettings, SACSettings
from robomore.training.value_bins import expected_value


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
    policy: Callable[[TrainingRun, networks.Sizes], networks.Folded]
    critics: Callable[[TrainingRun, networks.Sizes], list[networks.Folded]]


def _folded(parameters: Any, moments: Any, sizes: networks.Sizes) -> networks.Folded:
    return networks.fold(networks.layers(parameters, sizes), networks.moments(moments, sizes))


CROSSQ = Algorithm(
    CrossQ,
    SETTINGS,
    lambda run, sizes: _folded(*run.state.actor[:2], sizes),
    lambda run, sizes: [_folded(*each, sizes) for each in zip(*run.state.critics[:2], strict=True)],
)
PLAIN = Algorithm(
    SAC,
    SAC_SETTINGS,
    lambda run, sizes: perceptron.layers(run.state.actor.parameters, sizes),
    lambda run, sizes: [perceptron.layers(each, sizes) for each in run.state.critics.parameters],
)


HISTOGRAMS = replace(CROSSQ, settings=replace(SETTINGS, num_bins=51, n_critics=1))

ALGORITHMS = [CROSSQ, HISTOGRAMS, PLAIN]
MAINLY_CROSSQ = pytest.mark.parametrize(
    "algorithm", more_of(ALGORITHMS, CROSSQ), ids=["crossq", "histograms", "sac"], indirect=True
)
"""Where the value of a truncated episode, tried with both each time, would be wrong as well."""


@pytest.fixture(params=ALGORITHMS, ids=["crossq", "histograms", "sac"])
def algorithm(request: pytest.FixtureRequest) -> Any:
    return request.param


def trained(
    algorithm: Algorithm,
    probe: Any,
    steps: int,
    seed: int = 1,
    alpha: float = 1e-4,
    policy_ema_fraction: float = 0.0,
) -> TrainingRun:
    # What the compiled step does not read is set past its settings: compiling takes long.
    settings = replace(algorithm.settings, policy_ema_fraction=policy_ema_fraction)
    run = TrainingRun(algorithm.make(algorithm.settings), settings, probe, seed)
    log_alpha: Any = np.log(np.float32(alpha))
    actor = run.state.actor
    actor = actor._replace(alpha=actor.alpha._replace(log=log_alpha))
    run.state = run.state._replace(actor=actor)
    while run.steps < steps:
        run.advance()
    return run


def values(
    algorithm: Algorithm, run: TrainingRun, observation: list[float], action: float
) -> NDArray[np.float32]:
    """Values that each critic gives one state and action, in units of the reward."""
    scale = run.buffer.scale
    inputs: Any = np.array([[*observation, action]], np.float32)
    bins = getattr(algorithm.settings, "num_bins", 0)
    critics = algorithm.critics(run, (3, *algorithm.settings.net_arch, bins or 1))
    outputs = [networks.apply(critic, inputs)[0] for critic in critics]
    normalised = np.array([expected_value(out) if bins else out.item() for out in outputs])
    return normalised * scale.unit + scale.usual


@MAINLY_CROSSQ
def test_the_value_of_one_step_is_its_reward(algorithm: Algorithm) -> None:
    run = trained(algorithm, ProbeEnv(lambda elapsed, bit, action: 2.0 * bit - 1, length=1), 8_000)
    assert values(algorithm, run, [0, 1], 0.3) == pytest.approx(1, abs=0.1)
    assert values(algorithm, run, [0, 0], 0.3) == pytest.approx(-1, abs=0.1)


@MAINLY_CROSSQ
def test_the_value_of_an_earlier_step_is_discounted(algorithm: Algorithm) -> None:
    run = trained(algorithm, ProbeEnv(lambda elapsed, bit, action: elapsed == 1, length=2), 6_000)
    assert values(algorithm, run, [0.5, 1], 0.0) == pytest.approx(1, abs=0.1)
    assert values(algorithm, run, [0, 1], 0.0) == pytest.approx(algorithm.settings.gamma, abs=0.1)


@pytest.mark.parametrize(("ending", "value"), [((True, False), 1.0), ((False, True), 10.0)])
def test_truncation_bootstraps_and_termination_does_not(
    algorithm: Algorithm, ending: tuple[bool, bool], value: float
) -> None:
    # The last observation looks like the first, so a truncated episode goes on for ever.
    class Loop(ProbeEnv):
        def _observation(self) -> NDArray[np.float64]:
            return np.stack([np.zeros(self.num_envs), self.bit], axis=1)

    run = trained(algorithm, Loop(lambda elapsed, bit, action: np.ones(4), 1, ending), 4_000)
    assert values(algorithm, run, [0, 1], 0.0) == pytest.approx(value, rel=0.15)


def test_the_policy_picks_what_is_rewarded(algorithm: Algorithm) -> None:
    wanted = {0: -0.5, 1: 0.5}

    def reward(elapsed: Any, bit: Any, action: NDArray[Any]) -> NDArray[Any]:
        return -np.square(action[:, 0] - np.where(bit, wanted[1], wanted[0]))

    # The entropy is weighed against values on the scale that critics learn.
    alpha = 0.1 if algorithm is PLAIN else 1.0
    policy = trained(
        algorithm, ProbeEnv(reward, length=1), 6_000, alpha=alpha, policy_ema_fraction=0.3
    ).policies()[-1]
    for bit, best in wanted.items():
        assert policy.act(np.array([[0.0, bit]])) == pytest.approx(best, abs=0.2)


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
    network = algorithm.policy(run, (2, *algorithm.settings.net_arch, 2))
    given: Any = observations
    heads = networks.apply(network, given)
    assert run.policies()[-1].act(observations) == pytest.approx(np.tanh(heads[:, :1]), abs=1e-5)


def test_a_reward_too_large_for_its_numbers_is_said_so() -> None:
    with pytest.raises(TrainingDiverged, match="no longer a finite number"):
        trained(PLAIN, ProbeEnv(lambda elapsed, bit, action: np.full(4, 1e30)), 512)


def test_fewer_steps_than_one_round_are_refused(algorithm: Algorithm) -> None:
    with pytest.raises(InputError, match="one round of training is 16"):
        algorithm.make(algorithm.settings).train(Cart(), 10, seed=1)
