"""What is believed of a sandboxed process's words."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from robomore.evaluation.request import Answer, Training, checked_answer, checked_training
from robomore.training.policy import MLPPolicy
from robomore.types import (
    Curve,
    Design,
    Evaluation,
    Job,
    Morphology,
    Reward,
    Status,
    TermStatistics,
    TrainerSettings,
)

JOB = Job("ant", Design(Morphology((0.1,)), Reward("…")), TrainerSettings(), 100, 1, 7)
GOOD = Evaluation(
    "k1", JOB, Status.OK, fitness=1.0, volume=0.5, efficiency=2.0, episode_fitness=(1.0,)
)
POLICY = MLPPolicy((np.ones((2, 1), np.float32),), (np.zeros(1, np.float32),)).to_bytes()


def test_a_curve_is_carried_over() -> None:
    curve = Curve((16, 32), {"alpha": (None, 0.25), "term/forward": (1.5, -2.0)})
    assert checked_training(msgspec.json.encode(Training(32, curve=curve))).curve == curve
    assert checked_training(msgspec.json.encode(Training(32))).curve is None


def test_names_of_series_are_made_fit_to_be_shown() -> None:
    curve = Curve((1,), {"term/\x1b[2J": (0.0,)})
    found = checked_training(msgspec.json.encode(Training(1, curve=curve))).curve
    assert found is not None
    assert [name.isprintable() for name in found.series] == [True]


@pytest.mark.parametrize(
    "curve",
    [
        b'{"steps": [1, 2], "series": {"a": [0.0]}}',
        b'{"steps": [2, 1], "series": {}}',
        b'{"steps": [1], "series": {"a": [1e999]}}',
        b'{"steps": [1], "series": {"a": ["b"]}}',
        b'{"steps": [1], "series": {"a": [NaN]}}',
        b'{"steps": [1e300], "series": {}}',
        b'{"steps": [1' + b"0" * 30 + b'], "series": {}}',
        b'{"steps": [1], "series": {"' + b"x" * 101 + b'": [0.0]}}',
        b'{"steps": [' + b",".join(b"%d" % i for i in range(1, 66)) + b'], "series": {}}',
        b'{"steps": [1], "series": {'
        + b",".join(b'"term/%d": [0.0]' % i for i in range(65))
        + b"}}",
        b'{"steps": [1], "series": ' + b'{"a":' * 5_000 + b"1" + b"}" * 5_000 + b"}",
    ],
)
def test_anything_else_is_refused(curve: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        checked_training(b'{"steps": 1, "curve": ' + curve + b"}")


def test_names_of_terms_and_notes_are_one_line_each() -> None:
    claimed = Training(1, {"a\nb\x1b[2J": TermStatistics(0.0, 0.0, 0.0)}, ("one\ntwo\u202e",))
    found = checked_training(msgspec.json.encode(claimed))
    assert all(text.isprintable() for text in (*found.terms, *found.notes))
    assert "a b" in next(iter(found.terms))


def test_a_good_answer_is_carried_over() -> None:
    answer = Answer(GOOD, POLICY)
    assert checked_answer(msgspec.json.encode(answer), "k1", JOB) == answer
    failed = Answer(Evaluation("k1", JOB, Status.UNSTABLE, "why", artifact="k1"), POLICY)
    kept = checked_answer(msgspec.json.encode(failed), "k1", JOB)
    assert kept == Answer(replace(failed.evaluation, artifact=""), b"")


@pytest.mark.parametrize(
    "changes",
    [
        {"fitness": None},
        {"episode_fitness": [1.0, None]},
        {"behaviour": {"fell_share": None}},
        {"efficiency": "2.0"},
        {"volume": 0.0},
        {"volume": -1.0},
        {"key": "k2"},
        {"key": "../k1"},
        {"artifact": "../../outside"},
        {"artifact": "/etc"},
        {"artifact": ".."},
        {"status": "failed"},
        {"status": "fine"},
        {"diagnosis": 1},
        {"curve": {"steps": [2, 1], "series": {}}},
        {"job": {"task": "ant"}},
        {"job": None},
        {"notes": [[]]},
        {"efficiency": 1e11},
        {"fitness": 3.0},
        {"episode_fitness": [1.0, 99.0]},
        {"diagnosis": "x" * 2_000_000},
        {"notes": ["x" * 2_000_000]},
    ],
    ids=lambda changes: str(changes)[:60],
)
def test_an_answer_that_cannot_be_kept_is_refused(changes: dict[str, Any]) -> None:
    answer = msgspec.to_builtins(Answer(GOOD, POLICY))
    answer["evaluation"] |= changes
    with pytest.raises(ValueError, match=r"."):
        checked_answer(msgspec.json.encode(answer), "k1", JOB)


@pytest.mark.parametrize(
    "policy", [b"", b"policy", POLICY[:-1], POLICY.replace(b"bias0", b"bias1")]
)
def test_ok_without_a_policy_that_can_be_used_is_refused(policy: bytes) -> None:
    with pytest.raises(ValueError, match="policy"):
        checked_answer(msgspec.json.encode(Answer(GOOD, policy)), "k1", JOB)
    with pytest.raises(ValueError, match="more than"):
        checked_answer(msgspec.json.encode(Answer(GOOD, bytes(2**26) + POLICY)), "k1", JOB)


@pytest.mark.parametrize("reply", [b"", b"null", b"\xff", b"[" * 100_000, b'{"evaluation": 1e999}'])
def test_noise_is_refused(reply: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        checked_answer(reply, "k1", JOB)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_no_evaluation_has_numbers_that_are_not_finite(value: float) -> None:
    for changes in (
        {"fitness": value},
        {"episode_fitness": (value,)},
        {"behaviour": {"a": value}},
        {"terms": {"a": TermStatistics(0.0, value, 0.0)}},
        {"seconds": value},
    ):
        with pytest.raises(ValueError, match="not finite"):
            replace(GOOD, **changes)  # type: ignore[arg-type]
