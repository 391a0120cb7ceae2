"""Replies of all kinds, each in a file of its own with the expected outcome.

A file of `replies/` has headers, `---`, and the reply. Headers: `kind`; `accepted` (the idea of
the proposal) or `fault` (a part of the error); `truncated`; `escapes` (the reply is
written with Python's escapes); `repeat` (the reply is that often as long); `task` and `values`
(of another task's morphology); `terms` and `reward` (of another reward). Names with `model` are
modelled on what reasoning models and local servers send, those with `seen` on reports by users.
"""

from __future__ import annotations

import contextlib
import json
import time
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measured import SWIMMER

from robomore.designers.llm.code_extraction import find_code
from robomore.designers.llm.extraction import LONGEST, NotFound, find_object
from robomore.designers.llm.parsing import InvalidReply, parse_morphology, parse_reward
from robomore.rewards.check import Finding
from robomore.tasks import get_task
from robomore.types import Morphology, Reward

REPLIES = sorted((Path(__file__).parent / "replies").glob("*.txt"))
EXPECTED = (0.8, 0.9, 1.0, 0.02, 0.03, 0.04)
TAKEN_BODY = Morphology((0.5, 0.5, 0.5, 0.05, 0.05, 0.05))
TAKEN_REWARD = Reward(
    "def _get_rew(self, x_velocity, action):\n"
    '    """First."""\n'
    '    return float(x_velocity), {"speed": float(x_velocity)}\n'
)


@dataclass(frozen=True)
class Case:
    kind: str
    headers: dict[str, str]
    reply: str

    @classmethod
    def read(cls, path: Path) -> Case:
        # Line ends are part of a reply.
        head, _, reply = path.read_bytes().decode().partition("\n---\n")
        headers = dict(line.partition(": ")[::2] for line in head.split("\n"))
        headers = {name.rstrip(":"): value for name, value in headers.items()}
        if "escapes" in headers:
            reply = reply.encode("latin-1").decode("unicode_escape")
        return cls(headers["kind"], headers, reply * int(headers.get("repeat", "1")))

    def parse(self) -> Morphology | Reward:
        truncated = "truncated" in self.headers
        if self.kind == "morphology":
            task = get_task(self.headers["task"]) if "task" in self.headers else SWIMMER
            taken = [] if "task" in self.headers else [TAKEN_BODY]
            return parse_morphology(self.reply, task, taken, truncated)
        return parse_reward(self.reply, [TAKEN_REWARD], truncated)


@pytest.mark.parametrize("path", REPLIES, ids=lambda path: path.stem)
def test_reply(path: Path) -> None:
    case = Case.read(path)
    started = time.monotonic()
    if "fault" in case.headers:
        with pytest.raises(InvalidReply) as caught:
            case.parse()
        assert case.headers["fault"] in "; ".join(caught.value.errors)
        assert all(len(fault) < 500 and "\n" not in fault for fault in caught.value.errors)
    else:
        proposal = case.parse()
        assert proposal.idea == case.headers["accepted"]
        msgspec.json.encode(proposal)
        if isinstance(proposal, Morphology):
            values = case.headers.get("values", "").split()
            assert proposal.parameters == (tuple(map(float, values)) or EXPECTED)
        else:
            scope: dict = {"np": np}
            exec(proposal.source, scope)
            robot = type("Robot", (), {"data": type("Data", (), {"time": 0.0})})()
            reward, terms = scope["_get_rew"](robot, 2.0, np.ones(2))
            assert reward == pytest.approx(float(case.headers.get("reward", "1.98")))
            assert set(terms) == set(case.headers.get("terms", "speed effort").split())
    assert time.monotonic() - started < 10.0


def test_all_errors_of_the_code_come_at_once_with_their_lines() -> None:
    with pytest.raises(InvalidReply) as caught:
        parse_reward("import os\nimport sys\ndef reward(a):\n    return 1\n")
    errors = caught.value.errors
    assert [fault.split(":")[0] for fault in errors[:2]] == ["line 1", "line 2"]
    assert any("`os`" in fault for fault in errors) and any("`sys`" in fault for fault in errors)
    assert any("`reward`" in fault for fault in errors)


def test_many_empty_lines_take_no_time() -> None:
    code = "x = 1\n" + "\n" * 49_000 + TAKEN_REWARD.source.replace('    """First."""\n', "")
    started = time.monotonic()
    assert parse_reward(code).idea == ""
    assert time.monotonic() - started < 3.0  # it took 13 s


def test_warnings_do_not_stop_a_reward() -> None:
    reply = "def _get_rew(self, x_velocity, action):\n    return x_velocity, {}\n"
    warned = [Finding(1, "warning", "hm")]
    assert parse_reward(reply, check=lambda source: warned).source == reply
    with pytest.raises(InvalidReply, match="line 2: no"):
        parse_reward(reply, check=lambda source: [Finding(2, "error", "no")])


@given(st.lists(st.floats(0.06, 0.29), min_size=6, max_size=6), st.text(max_size=50))
def test_every_design_within_bounds_comes_back(values: list[float], idea: str) -> None:
    reply = json.dumps({"parameters": values, "description": idea})
    assert parse_morphology(f"So: {reply}", SWIMMER).parameters == tuple(values)


@given(st.text(alphabet="{}[]\":,#/\\`~'<>think parameters0.1\n\tdef_get_rew()", max_size=300))
def test_noise_never_breaks_the_parsers(noise: str) -> None:
    for parse in (lambda: parse_morphology(noise, SWIMMER), lambda: parse_reward(noise)):
        try:
            parse()
        except InvalidReply as bad:
            assert bad.errors


HOSTILE = ["[THINK]", "{", '{"', '"', "// ", "```\n", "<think>", "def f(", "import a\n"]
MORE_HOSTILE = ["{'a':", '{"parameters":', "[", "'", "\\", "{#", " ", "\n", "`", "~~~\n"]
MORE_HOSTILE += ["</think>", "class A:\n", "# ", '"""', "x = 1\n", "<think></thought>", '"\\']
MORE_HOSTILE += ["\\boxed{", "> ", "> _get_rew\n", "&amp;", "&quot;parameters&quot;"]
MORE_HOSTILE += ["[a][/a]", "<|channel|>analysis", "<|channel|>final", "<answer>", "/*", "``~"]
MORE_HOSTILE += [
    "```thinking\n",
    "Final:\n",
    "assistantfinal",
    "'\\",
    "<a " + "b" * 190,
    "</answer>",
]
MORE_HOSTILE += ["```\ndef _get_rew():\n x=1\n```\n", "```\ny=x\n```\n", '{"a":"{', "_", "<|x|>"]


@pytest.mark.parametrize(
    "unit", [*HOSTILE, *(pytest.param(u, marks=pytest.mark.exhaustive) for u in MORE_HOSTILE)]
)
def test_long_noise_is_read_in_linear_time(unit: str) -> None:
    text = unit * (LONGEST // len(unit))
    started = time.monotonic()
    for find in (lambda: find_object(text, "parameters"), lambda: find_code(text, "_get_rew")):
        with contextlib.suppress(NotFound):
            find()
    assert time.monotonic() - started < 10.0
