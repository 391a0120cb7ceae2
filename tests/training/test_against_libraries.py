"""One gradient step of ours against one of the libraries', from the same weights and batch.

SBX and Stable-Baselines3 are optional: without them this says that it was left out.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

from robomore.training.crossq import CrossQ
from robomore.training.sac import SAC
from robomore.training.settings import CrossQSettings, SACSettings

OBSERVATIONS, ACTIONS, BATCH = 5, 2, 64
NET_ARCH = (24, 16)
GAMMA = 0.97
NO_NOISE = -20.0
"""Logarithm of a deviation that leaves no randomness in an action, whichever library draws it."""


class Nothing(gymnasium.Env[Any, Any]):
    observation_space = gymnasium.spaces.Box(-10, 10, (OBSERVATIONS,), np.float32)
    action_space = gymnasium.spaces.Box(-1, 1, (ACTIONS,), np.float32)


@pytest.fixture
def batch() -> dict[str, NDArray[np.float32]]:
    random = np.random.default_rng(0)
    return {
        "observation": random.standard_normal((BATCH, OBSERVATIONS), np.float32) * 2 + 1,
        "action": 2 * random.random((BATCH, ACTIONS), np.float32) - 1,
        "next": random.standard_normal((BATCH, OBSERVATIONS), np.float32) * 2 + 1,
        "reward": random.standard_normal(BATCH, np.float32),
        "done": (random.random(BATCH) < 0.2).astype(np.float32),
    }


def packed(batch: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
    """Return the batch as one round of our rows."""
    future = GAMMA * (1 - batch["done"])
    parts = [batch["observation"], batch["action"], batch["next"]]
    parts += [batch["reward"][:, None], future[:, None]]
    return np.concatenate(parts, axis=1)[None]


def close(ours: Any, theirs: Any) -> None:
    assert np.asarray(ours) == pytest.approx(np.asarray(theirs), rel=2e-4, abs=2e-6)


def test_a_step_of_crossq_is_that_of_sbx(batch: dict[str, NDArray[np.float32]]) -> None:
    sbx = pytest.importorskip("sbx")
    import jax
    import jax.numpy as jnp

    model = sbx.CrossQ("MlpPolicy", Nothing(), policy_kwargs={"net_arch": list(NET_ARCH)}, seed=1)
    actor, critic = model.policy.actor_state, model.policy.qf_state
    silent = jax.tree.map(lambda leaf: leaf, actor.params)
    silent["Dense_3"] = {
        "kernel": jnp.zeros_like(silent["Dense_3"]["kernel"]),
        "bias": jnp.full_like(silent["Dense_3"]["bias"], NO_NOISE),
    }
    actor = actor.replace(params=silent)
    worthless = jax.tree.map(lambda leaf: jnp.full_like(leaf, -100.0), model.ent_coef_state.params)
    entropy = model.ent_coef_state.replace(params=worthless)
    before_critics = flat_critics(critic.params)
    before_actor = flat_actor(actor.params)
    stepped, (loss, _), key = model.update_critic(
        actor,
        critic,
        entropy,
        batch["observation"],
        batch["action"],
        batch["next"],
        batch["reward"],
        batch["done"],
        np.full(BATCH, GAMMA, np.float32),
        model.key,
    )
    acted, *_ = model.update_actor(actor, stepped, entropy, batch["observation"], key)

    settings = CrossQSettings(
        net_arch=NET_ARCH,
        batch_size=BATCH,
        gradient_steps=1,
        init_alpha=1e-40,
        n_critics=2,
        min_q_weight=1.0,
    )
    trainer = CrossQ(settings)
    state, _ = trainer.begin(np.random.default_rng(0), OBSERVATIONS, ACTIONS)
    critics = state.critics._replace(parameters=before_critics)
    alpha = state.actor.alpha._replace(log=np.float32(-100.0))
    state = state._replace(
        critics=critics, actor=state.actor._replace(parameters=before_actor, alpha=alpha)
    )
    noise = np.zeros((1, 2, BATCH, ACTIONS), np.float32)
    state, _, losses = trainer.learn(state, packed(batch), noise, done=0)

    close(losses["loss/critic"], loss)
    close(state.critics.parameters, flat_critics(stepped.params))
    # Adam's first step shows little but signs of the gradients; its running mean shows them.
    close(state.critics.adam.mean, flat_critics(stepped.opt_state[0].mu))
    close(state.critics.moments, flat_moments(stepped.batch_stats["VmapCritic_0"]))
    # The mean's half of the policy; the other one is without gradient here but for noise.
    ours, theirs = state.actor, acted
    close(actor_means(ours.parameters), actor_means(flat_actor(theirs.params)))
    close(actor_means(ours.adam.mean), actor_means(flat_actor(theirs.opt_state[0].mu)))


def test_steps_of_sac_are_those_of_stable_baselines3(
    batch: dict[str, NDArray[np.float32]], monkeypatch: pytest.MonkeyPatch
) -> None:
    sb3 = pytest.importorskip("stable_baselines3")
    import torch
    from stable_baselines3.common.logger import Logger
    from stable_baselines3.common.type_aliases import ReplayBufferSamples

    policy_kwargs = {"net_arch": list(NET_ARCH)}
    model = sb3.SAC("MlpPolicy", Nothing(), policy_kwargs=policy_kwargs, gamma=GAMMA, seed=1)
    model.set_logger(Logger(folder=None, output_formats=[]))
    settings = SACSettings(net_arch=NET_ARCH, batch_size=BATCH, gradient_steps=1)
    trainer = SAC(settings)
    state, _ = trainer.begin(np.random.default_rng(0), OBSERVATIONS, ACTIONS)
    critics = np.stack([torch_flat(each) for each in model.critic.q_networks])
    state = state._replace(
        critics=state.critics._replace(parameters=critics, targets=critics.copy()),
        actor=state.actor._replace(parameters=torch_actor(model)),
    )

    columns = ["observation", "action", "next", "done", "reward"]
    tensors = {name: torch.from_numpy(batch[name]).reshape(BATCH, -1) for name in columns}
    sample = ReplayBufferSamples(*(tensors[name] for name in columns))
    monkeypatch.setattr(model.replay_buffer, "sample", lambda *args, **more: sample)
    random = np.random.default_rng(1)
    for _ in range(3):
        noise = random.standard_normal((2, BATCH, ACTIONS), np.float32)
        drawn = iter((noise[1], noise[0]))  # The library draws for the policy first.

        def draw(self: Any, shape: Any = (), drawn: Any = drawn) -> Any:
            return self.loc + self.scale * torch.from_numpy(next(drawn))

        monkeypatch.setattr(torch.distributions.Normal, "rsample", draw)
        model.train(gradient_steps=1, batch_size=BATCH)
        state, _, losses = trainer.learn(state, packed(batch), noise[None], done=0)
        said = model.logger.name_to_value
        close(losses["loss/critic"], said["train/critic_loss"])
        close(losses["loss/actor"], said["train/actor_loss"])
    close(state.actor.parameters, torch_actor(model))
    close(state.critics.parameters, np.stack([torch_flat(q) for q in model.critic.q_networks]))
    close(state.critics.targets, np.stack([torch_flat(q) for q in model.critic_target.q_networks]))
    close(state.actor.alpha.log, model.log_ent_coef.item())


def torch_flat(*modules: Any) -> NDArray[np.float32]:
    """Return the linear layers of PyTorch modules, one after the other, flat and our way round."""
    parts = []
    for module in modules:
        for parameter in module.parameters():
            parts.append(parameter.detach().numpy().T.ravel())
    return np.concatenate(parts)


def torch_actor(model: Any) -> NDArray[np.float32]:
    """Return Stable-Baselines3's policy as our flat parameters; its two heads are side by side."""
    actor = model.actor
    heads = [
        np.concatenate(
            [getattr(head, name).detach().numpy().T for head in (actor.mu, actor.log_std)], -1
        )
        for name in ("weight", "bias")
    ]
    return np.concatenate([torch_flat(actor.latent_pi), *(head.ravel() for head in heads)])


def flat_critics(parameters: Any) -> NDArray[np.float32]:
    """Return SBX's critics as our flat parameters, one critic a row."""
    parts = parameters["VmapCritic_0"]
    rows = []
    for i in range(2):
        found = []
        for j in range(len(NET_ARCH) + 1):
            norm, dense = parts[f"BatchRenorm_{j}"], parts[f"Dense_{j}"]
            found += [norm["scale"][i], norm["bias"][i], dense["kernel"][i].ravel()]
            found += [dense["bias"][i]]
        rows.append(np.concatenate([np.ravel(part) for part in found]))
    return np.stack(rows).astype(np.float32)


def flat_moments(statistics: Any) -> NDArray[np.float32]:
    rows = []
    for i in range(2):
        found = []
        for j in range(len(NET_ARCH) + 1):
            found += [statistics[f"BatchRenorm_{j}"][name][i] for name in ("mean", "var")]
        rows.append(np.concatenate(found))
    return np.stack(rows).astype(np.float32)


def flat_actor(parameters: Any) -> NDArray[np.float32]:
    """Return SBX's policy as our flat parameters; its two heads are our last layer's columns."""
    found = []
    for j in range(len(NET_ARCH) + 1):
        norm = parameters[f"BatchRenorm_{j}"]
        found += [norm["scale"], norm["bias"]]
        if j < len(NET_ARCH):
            dense = parameters[f"Dense_{j}"]
            found += [dense["kernel"].ravel(), dense["bias"]]
    mean, deviation = (parameters[f"Dense_{len(NET_ARCH) + k}"] for k in (0, 1))
    found += [np.concatenate([mean["kernel"], deviation["kernel"]], axis=1).ravel()]
    found += [np.concatenate([mean["bias"], deviation["bias"]])]
    return np.concatenate([np.ravel(part) for part in found]).astype(np.float32)


def actor_means(parameters: Any) -> NDArray[np.float32]:
    """Return a flat policy without what gives the deviations."""
    last = NET_ARCH[-1] * 2 * ACTIONS + 2 * ACTIONS
    inner, outer = np.asarray(parameters[:-last]), np.asarray(parameters[-last:])
    weight = outer[: -2 * ACTIONS].reshape(NET_ARCH[-1], 2 * ACTIONS)[:, :ACTIONS]
    bias = outer[-2 * ACTIONS :][:ACTIONS]
    return np.concatenate([inner, weight.ravel(), bias])
