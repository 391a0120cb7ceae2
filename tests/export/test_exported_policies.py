"""Policies in two forms, run by an ONNX runtime that we did not write and by NumPy alone."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest

from robomore.errors import ExportFailed
from robomore.export.policies import ensure_agreement, numpy_module, onnx_bytes, trial_observations
from robomore.training.policy import MLPPolicy


def made_up(*sizes: int, scale: float = 1.0) -> MLPPolicy:
    random = np.random.default_rng(0)
    pairs = list(pairwise(sizes))
    weights = [scale * random.standard_normal(pair) / np.sqrt(pair[0]) for pair in pairs]
    biases = [random.standard_normal(pair[1]) for pair in pairs]
    return MLPPolicy(
        tuple(np.float32(one) for one in weights), tuple(np.float32(one) for one in biases)
    )


@pytest.mark.parametrize("sizes", [(17, 128, 128, 6), (3, 1), (105, 256, 256, 256, 8)])
def test_onnx_acts_as_the_policy(sizes: tuple[int, ...]) -> None:
    policy = made_up(*sizes)
    content = onnx_bytes(policy, {"task": "ant"})
    session = onnxruntime.InferenceSession(content)
    observations = trial_observations(policy)
    for batch in (observations, observations[:1]):
        (actions,) = session.run(None, {"observation": batch})
        np.testing.assert_allclose(actions, policy.act(batch), atol=1e-5)
    assert session.get_modelmeta().custom_metadata_map == {"task": "ant"}
    assert content == onnx_bytes(policy, {"task": "ant"})
    onnx.checker.check_model(onnx.load_model_from_string(content), full_check=True)


def test_one_file_acts_as_the_policy_and_imports_numpy_alone(tmp_path: Path) -> None:
    policy = made_up(5, 16, 16, 2)
    (tmp_path / "policy.py").write_text(numpy_module(policy, "a robot"))
    np.save(tmp_path / "in.npy", trial_observations(policy))
    code = (
        "import sys, numpy as np; from policy import act, OBSERVATION_SIZE, ACTION_SIZE\n"
        "assert (OBSERVATION_SIZE, ACTION_SIZE) == (5, 2)\n"
        "assert not {'robomore', 'jax', 'torch', 'onnx', 'gymnasium'} & set(sys.modules)\n"
        "x = np.load('in.npy'); assert act(x[0]).shape == (2,)\n"
        "np.save('out.npy', act(x.astype(np.float64)))"
    )
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, timeout=60)
    assert np.array_equal(np.load(tmp_path / "out.npy"), policy.act(trial_observations(policy)))


def test_another_action_is_refused() -> None:
    policy = made_up(3, 2)
    actions = policy.act(trial_observations(policy))
    ensure_agreement("test", actions, policy)
    with pytest.raises(ExportFailed, match="acts otherwise"):
        ensure_agreement("test", actions + 2e-5, policy)
    with pytest.raises(ExportFailed):
        ensure_agreement("test", np.full_like(actions, np.nan), policy)
