"""A trained policy in two forms that need neither RoboMoRe nor a learning library.

Both take an observation as the environment gives it and return an action in [-1, 1]: whatever
normalises observations is folded into the weights, and `tanh` bounds the actions.
"""

from __future__ import annotations

import base64
import textwrap

import numpy as np

from robomore.errors import ExportFailed
from robomore.export.templates import template
from robomore.training.policy import MLPPolicy

AGREEMENT = 1e-5
"""Largest difference of an action from that of the policy that was trained."""

_OPSET, _IR = 17, 8
"""Old enough for the runtimes of small computers."""
_TRIALS = 64


def onnx_bytes(policy: MLPPolicy, facts: dict[str, str]) -> bytes:
    """Return a policy as an ONNX model: `observation` (n, inputs) to `action` (n, outputs).

    Args:
        policy: what was trained.
        facts: kept in the model's metadata.

    Raises:
        ExportFailed: the model does not act as the policy does.
    """
    import onnx
    from onnx import TensorProto, helper, numpy_helper
    from onnx.reference import ReferenceEvaluator

    nodes, constants, value = [], [], "observation"
    for i, (weight, bias) in enumerate(zip(policy.weights, policy.biases, strict=True)):
        constants += [
            numpy_helper.from_array(np.ascontiguousarray(weight), f"weight{i}"),
            numpy_helper.from_array(np.ascontiguousarray(bias), f"bias{i}"),
        ]
        last = i == len(policy.weights) - 1
        nodes += [
            helper.make_node("Gemm", [value, f"weight{i}", f"bias{i}"], [f"linear{i}"]),
            helper.make_node(
                "Tanh" if last else "Relu", [f"linear{i}"], ["action" if last else f"hidden{i}"]
            ),
        ]
        value = f"hidden{i}"
    inputs, *_, outputs = policy.sizes
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("observation", TensorProto.FLOAT, ["n", inputs])],
        [helper.make_tensor_value_info("action", TensorProto.FLOAT, ["n", outputs])],
        constants,
    )
    model = helper.make_model(
        graph,
        producer_name="robomore",
        opset_imports=[helper.make_opsetid("", _OPSET)],
        ir_version=_IR,
    )
    helper.set_model_props(model, facts)
    onnx.checker.check_model(model, full_check=True)
    trials = trial_observations(policy)
    (actions,) = ReferenceEvaluator(model).run(None, {"observation": trials})
    ensure_agreement("ONNX", actions, policy)
    content: bytes = model.SerializeToString(deterministic=True)
    return content


def numpy_module(policy: MLPPolicy, title: str) -> str:
    """Return a policy as the text of one Python file that imports NumPy alone.

    Args:
        policy: what was trained.
        title: of its robot, for people.

    Raises:
        ExportFailed: the file does not act as the policy does.
    """
    layers = ",\n".join(
        f"    ({weight.shape[0]}, {weight.shape[1]}, {_packed(weight)}, {_packed(bias)})"
        for weight, bias in zip(policy.weights, policy.biases, strict=True)
    )
    inputs, *hidden, outputs = policy.sizes
    text = template(
        "policy.py",
        title=title,
        inputs=str(inputs),
        outputs=str(outputs),
        hidden=" and ".join(map(str, hidden)) or "no",
        layers=layers,
    )
    names: dict[str, object] = {"__name__": "policy"}
    exec(compile(text, "policy.py", "exec"), names)  # our own template, and numbers
    act = names["act"]
    assert callable(act)
    ensure_agreement("NumPy", act(trial_observations(policy)), policy)
    return text


def trial_observations(policy: MLPPolicy) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Return observations (n, inputs) on which two forms of a policy are compared."""
    random = np.random.default_rng(0)
    scales = 10.0 ** random.uniform(-2, 1, (_TRIALS, 1))
    drawn = scales * random.standard_normal((_TRIALS, policy.sizes[0]))
    return np.asarray(drawn, np.float32)


def ensure_agreement(form: str, actions: object, policy: MLPPolicy) -> None:
    """Refuse actions that are not those of the policy on `trial_observations`.

    Raises:
        ExportFailed: they differ by more than `AGREEMENT`.
    """
    apart = np.abs(np.asarray(actions) - policy.act(trial_observations(policy))).max()
    if not apart <= AGREEMENT:
        raise ExportFailed(
            f"the exported {form} policy acts otherwise than the trained one (by {apart:.2g}, and "
            f"{AGREEMENT:g} is allowed); its weights may be too large for 32-bit numbers"
        )


def _packed(array: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> str:
    """Return numbers as text in lines that an editor can show."""
    text = base64.b64encode(np.ascontiguousarray(array, "<f4").tobytes()).decode()
    lines = textwrap.wrap(text, 88, break_long_words=True) or [""]
    return '"""\n' + "\n".join(lines) + '\n"""'
