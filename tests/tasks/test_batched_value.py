"""Values of many simulations at once behave as the value of each one."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robomore.envs.batched.names import StandIns
from robomore.envs.batched.run import Divided, Refused, Run
from robomore.envs.batched.value import Batched

M = 5


class Inputs:
    """A number, a vector, a matrix, and positive and whole versions of some."""

    def __init__(self, run: Run | None, index: int = 0) -> None:
        random = np.random.default_rng(0)
        values = {
            "x": random.normal(size=M),
            "v": random.normal(size=(6, M)),
            "u": random.normal(size=(6, M)),
            "m": random.normal(size=(3, 6, M)),
            "p": random.uniform(0.5, 2.0, size=M),
            "k": random.integers(-3, 4, size=M),
            "b": random.normal(size=(6, M)) > 0,
            "one": random.normal(size=(1, M)),
        }
        for name, value in values.items():
            if run is not None:
                setattr(self, name, Batched(value.copy(), run))
            else:
                part = value[..., index]
                setattr(self, name, part.copy() if part.ndim else part[()])

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)


EXPRESSIONS = """
x + 1 | 2 - x | x * v | v / p | 1.5 / p | v // p | v % p | p ** 2 | p ** 0.5 | 2 ** x | -v | +x
abs(v) | x + np.float64(2) | np.float64(2) * v | np.arange(6.0) * v | v * np.arange(6.0)
[1.0, 2, 3, 4, 5, 6] * v | x < 0.5 | 0.5 < x | (v > 0) & b | (v > 0) | ~b | x == x | v != v
v >= u | v <= 0 | b * 2.0 | b ^ b | v[0] | v[-1] | v[1:4] | v[::2] | v[1::2] - v[::2]
v[[0, 2, 5]] | v[np.array([1, 1])] | v[None] | v[..., 0] | m[0] | m[1, 2] | m[:, 1] | m[..., -1]
m[0, 1:3] | m[:, [0, 1]] | m[None, 0] | v[np.arange(6) > 2] | m.T | v.T | len(v) | v.shape
m.shape | m.ndim | x.ndim | m.size | v.dtype | np.shape(m) | np.ndim(x) | v.sum() | m.sum(axis=0)
m.sum(axis=-1) | m.mean(axis=1, keepdims=True) | v.max() - v.min() | v.std() | v.var(ddof=1)
v.prod() | b.any() | b.all() | b.sum() | v.argmax() | v.argmin() | v.dot(u) | v.clip(-0.5, 0.5)
v.round(2) | v.cumsum() | v.reshape(2, 3) | v.reshape((3, -1)) | m.ravel() | m.flatten()
m.flat[3] | v.copy() | v.astype(int) | one.item() | v.tolist() | one.squeeze() | bool(one > -99)
v.item(2) | m @ v | v @ u | np.ones((2, 6)) @ v | v @ np.ones((6, 2)) | np.sum(np.square(v))
np.sum(m) | np.sum(m, axis=(0, 1)) | np.mean(m, 0) | np.prod(v) | np.max(v) | np.amin(m, axis=1)
np.median(v) | np.ptp(v) | np.std(m, axis=1) | np.var(v) | np.any(b) | np.all(v > -9)
np.count_nonzero(b) | np.clip(x, 0, None) | np.clip(v, a_min=-0.1, a_max=p) | np.clip(v, u, 1.0)
np.where(v > 0, v, 0.0) | np.where(x > 0, 1.0, v) | np.linalg.norm(v) | np.linalg.norm(m, axis=1)
np.linalg.norm(v, ord=1) | np.linalg.norm(v[:3], 2) | np.linalg.norm(m) | np.dot(v, u)
np.dot(x, v) | np.dot(m, v) | np.dot(v, np.arange(6.0)) | np.inner(v, u) | np.outer(v, u)
np.cross(v[:3], u[:3]) | np.diff(v) | np.diff(m, axis=0) | np.abs(np.diff(v, n=2))
np.concatenate([v, u]) | np.concatenate((m, m), axis=1) | np.concatenate([v, [1.0, 2.0]])
np.stack([v, u]) | np.hstack([v, u]) | np.hstack([x, p]) | np.vstack([v, u]) | np.append(v, x)
np.array([x, p, 3.0]) | np.array([[x, 1], [p, x]]) | np.array(v) | np.asarray(x)
np.array([1.0, 2.0]) * x | np.array([x, p]).mean() | np.zeros(3) + x | np.ones((2, 2)) * p
np.full(3, x) | np.full(2, 1.5) - x | np.zeros_like(v) | np.ones_like(m) | np.full_like(v, 2.0)
np.exp(-x ** 2) | np.tanh(v) | np.sign(v) | np.log1p(p) | np.sqrt(p) | np.sin(v)
np.arctan2(x, p) | np.hypot(x, p) | np.power(v, 6) | np.minimum(v, 0.1) | np.maximum(u, v)
np.maximum(0, x) | np.heaviside(x, 0.5) | np.isfinite(v) | np.isnan(x) | np.floor(v)
np.modf(x)[0] | np.divmod(p, 0.3)[1] | np.add.reduce(v) | np.maximum.reduce([x, p])
np.nan_to_num(v) | np.round(x, 1) | np.fabs(x) | np.sort(v) | np.argsort(v) | np.flip(v)
np.roll(v, 1) | np.interp(x, [-1, 0, 1], [0, 5, 6]) | np.percentile(v, 30)
np.corrcoef(v, u)[0, 1] | np.polyval([1.0, 2.0], x) | np.average(v, weights=[1, 2, 3, 4, 5, 6])
np.isclose(x, p) | np.linalg.det(m[:, :3]) | np.tile(v, 2) | np.trace(m) | np.sum([x, p, 1.0])
np.mean([x, p]) | np.max([x, p]) | np.linalg.norm([x, p]) | np.square([x, p]) | np.isscalar(x)
np.isscalar(v) | np.float64(x) | np.copy(v) | np.ravel(m) | np.cumsum(v)
np.linalg.norm(m, "fro", (0, 1)) | np.allclose(v, v) | max(x, 0) | min(x, p, 0.2) | max(v)
min([x, p]) | max(k, 1) | sum(v) | sum([x, p]) | sum(a * a for a in v) | round(x) | round(x, 2)
float(x) | float(b[0]) | int(p) | int(b[1]) | int(k) | abs(x) | pow(p, 2) | divmod(p, 0.3)[0]
isinstance(x, float) | isinstance(x, (int, float)) | isinstance(v, np.ndarray)
isinstance(k, float) | float("2") + x | [a * 2 for a in v][1] | list(zip(v, u))[2][1]
math.exp(x) | math.sqrt(p) | math.sin(x) + math.pi | math.atan2(x, 2) | math.floor(x)
math.ceil(p) | math.log(p, 2) | math.log(p) | math.hypot(x, p) | math.pow(p, 3)
math.copysign(1, x) | math.isfinite(x) | math.degrees(x) | math.exp(1.0) * x | math.tanh(x)
""".replace("\n", "|").split("|")


@pytest.fixture
def run() -> Run:
    made = Run()
    made.width = M
    return made


def evaluated(expression: str, inputs: Inputs, names: dict[str, Any]) -> Any:
    return eval(expression, {**names, **vars(inputs)})


@pytest.mark.parametrize("expression", [one.strip() for one in EXPRESSIONS if one.strip()])
def test_each_simulation_gets_its_own(expression: str, run: Run) -> None:
    stand_ins = StandIns(run)
    ours = {"np": stand_ins.module(np), "math": stand_ins.module(math)}
    batched = evaluated(expression, Inputs(run), {**ours, "__builtins__": stand_ins.builtins})
    for index in range(M):
        truth = evaluated(expression, Inputs(None, index), {"np": np, "math": math})
        compare(batched, truth, index)


def compare(batched: Any, truth: Any, index: int) -> None:
    if isinstance(truth, (list, tuple)):
        assert type(batched) is type(truth) and len(batched) == len(truth)
        for one, other in zip(batched, truth, strict=True):
            compare(one, other, index)
        return
    value = batched.values[..., index] if type(batched) is Batched else batched
    assert np.shape(value) == np.shape(truth)
    if isinstance(truth, np.dtype):
        assert value == truth
        return
    assert (np.asarray(value).dtype == bool) == (np.asarray(truth).dtype == bool)
    np.testing.assert_allclose(value, truth, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    "program",
    [
        "v[0] = x",
        "v[1:3] = 0.5",
        "v[:] = u",
        "v[v > 0] = 0.0",
        "m[0, 1] = x",
        "v += u",
        "v *= 2",
        "v -= x",
        "w = v; v += 1; u[0] = w[0]",
        "w = v[2:]; w *= 3",
        "w = v[0]; v[0] = 9.0; u[1] = w",
        "w = x; x += 1; u[1] = w",
        "w = one.item(); one += 1; u[1] = w",
        "w = one.reshape(()); u[1] = w; one += 1",
        "a = np.zeros(6); a[2] = x; v[:] = a",
        "a = np.array([1.0, 2.0]); a[0] = x; v[:2] = a",
        "v /= p; v **= 2; v //= 0.1; v %= 0.7",
        "w = v.copy(); w[0] = 5; u[2] = v[0] + w[0]",
    ],
)
def test_arrays_are_changed_in_place_and_numbers_are_not(program: str, run: Run) -> None:
    stand_ins = StandIns(run)
    ours = {**vars(Inputs(run)), "np": stand_ins.module(np)}
    exec(program, ours)
    for index in range(M):
        theirs = {**vars(Inputs(None, index)), "np": np}
        exec(program, theirs)
        for name in ("x", "v", "u", "m"):
            compare(ours[name], theirs[name], index)


@pytest.mark.parametrize(
    "expression",
    [
        "v[k]",
        "v[v > 0]",
        "list(range(k))",
        "f'{x:.2f}'",
        "str(x)",
        "v.nonsense",
        "np.random.normal()",
        "np.random.default_rng(0)",
        "np.where(v > 0)",
        "np.add(v, 1.0, out=v)",
        "np.copyto(v, u)",
        "np.add.at(v, 0, 1.0)",
        "np.fill_diagonal(m, 0.0)",
        "np.unique(np.round(v))",
        "float(v)",
        "int(x / 0.0)",
        "float(one)",
        "math.tanh(one)",
        "max(one, 0.0)",
        "bool(v > 0)",
        "v + object()",
        "globals()",
        "__import__('random')",
        "__import__('os').getcwd()",
        "np.float32(x)",
        "complex(x)",
        "math.fsum(v)",
        "np.array([x], dtype=object) + 'a'",
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_what_does_not_work_for_many_is_refused(expression: str, run: Run) -> None:
    stand_ins = StandIns(run)
    names = {"np": stand_ins.module(np), "math": stand_ins.module(math)}
    with pytest.raises((Refused, TypeError, ValueError)):
        evaluated(expression, Inputs(run), {**names, "__builtins__": stand_ins.builtins})


@pytest.mark.parametrize(
    "expression", ["x[0]", "v[7]", "v[0, 0]", "m[0, 0, 0]", "len(x)", "v[True]"]
)
def test_mistakes_stay_mistakes(expression: str, run: Run) -> None:
    if expression != "v[True]":
        with pytest.raises((IndexError, TypeError)):
            evaluated(expression, Inputs(None), {"np": np})
    with pytest.raises((IndexError, TypeError, Refused)):
        evaluated(expression, Inputs(run), {"np": np})


def test_conditions_need_all_simulations_to_agree(run: Run) -> None:
    inputs = Inputs(run)

    def condition() -> str:
        return "yes" if inputs.p > 0 and not inputs.p > 5 else "no"

    assert run.of(M, condition) == "yes"
    assert run.outcomes == [True, False]
    with pytest.raises(Divided) as divided:
        run.of(M, lambda: bool(inputs.x > 0))
    assert divided.value.holds.tolist() == (inputs.x.values > 0).tolist()
    with pytest.raises(Refused):
        run.of(M, lambda: bool(inputs.v > 0))


def swallowing(work: Callable[[], Any]) -> Any:
    try:
        return work()
    except BaseException:  # noqa: BLE001  # as some rewards do
        return "swallowed"


def test_a_reward_cannot_swallow_what_ends_its_run(run: Run) -> None:
    inputs = Inputs(run)
    with pytest.raises(Divided):
        run.of(M, swallowing, lambda: bool(inputs.x > 0))
    with pytest.raises(Refused, match="as text"):
        run.of(M, swallowing, lambda: f"{inputs.x}")
    assert run.of(M, swallowing, lambda: inputs.v[99]) == "swallowed"


def test_faults_of_floating_point_are_noted_where_python_would_raise(run: Run) -> None:
    inputs = Inputs(run)
    run.of(M, lambda: inputs.x / 2)
    assert not run.faults
    run.of(M, lambda: 1.0 / (inputs.x * 0.0))
    assert run.faults


def test_official_code_reaches_plain_numpy(run: Run) -> None:
    """Without stand-ins, NumPy itself asks the value how to be called."""
    inputs = Inputs(run)
    total = np.sum(np.square(inputs.v))
    joined = np.concatenate([inputs.v.flat, inputs.u.flat])
    for index in range(M):
        truth = Inputs(None, index)
        compare(total, np.sum(np.square(truth.v)), index)
        compare(joined, np.concatenate([truth.v, truth.u]), index)


def test_copies_are_copies(run: Run) -> None:
    value = Inputs(run).v
    for made in (copy.copy(value), copy.deepcopy(value), value.copy()):
        made[0] = 1.0
        assert not np.array_equal(made.values[0], value.values[0])
