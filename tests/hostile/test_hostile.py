"""Strangers let loose: none may get anything across the boundary, whatever becomes of them."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
import pytest
from attempts import Attempt, attempts
from miniature import BEST, Claims, measure
from world import World, encode, world

from robomore.rewards.check import check_reward
from robomore.sandbox.call import SandboxResult, run_sandboxed
from robomore.sandbox.layers import strict_is_possible
from robomore.types import Limits, Status

pytestmark = pytest.mark.skipif(
    not strict_is_possible(), reason="this machine cannot contain a stranger"
)

LIMITS = Limits(
    wall_seconds=12.0,
    reward_call_seconds=0.4,
    stall_seconds=2.5,
    memory_bytes=400 * 2**20,
    file_bytes=8 * 2**20,
)

HONEST = (
    "def _get_rew(self, x_velocity, action):\n    return float(x_velocity), {'speed': x_velocity}\n"
)


@pytest.fixture(scope="module")
def planted() -> Iterator[World]:
    with world() as made:
        yield made


@pytest.mark.parametrize("attempt", attempts(), ids=lambda attempt: attempt.name)
def test_nothing_gets_across(
    attempt: Attempt, planted: World, record_property: pytest.RecordProperty
) -> None:
    source = planted.address(attempt.source)
    severities = {finding.severity for finding in check_reward(source)}
    checked = next((it for it in ("error", "warning") if it in severities), "clean")
    scratch = planted.scratch(attempt.name)
    contained = run_sandboxed(
        "miniature:train",
        encode(source),
        scratch,
        LIMITS,
        readable=[planted.root / "readable"],
    )
    breaches = planted.breaches(contained, scratch)
    record_property("attempt", attempt.words)
    record_property("check", checked)
    record_property("outcome", contained.status.value)
    record_property("breaches", "; ".join(breaches) or "none")

    assert not breaches
    assert contained.status in attempt.expected, contained.diagnosis + contained.log
    assert checked in attempt.check
    assert (contained.diagnosis == "") == (contained.status is Status.OK)
    assert len(contained.diagnosis) < 50_000
    if contained.status is Status.OK:
        assert _fitness(contained, planted, attempt) <= BEST


KNOWN_ESCAPES = {
    "format strings": ("escape/format_string", "escape/format_map"),
    "walks over types": ("escape/subclasses", "escape/metaclass"),
    "__globals__": ("escape/builtins_through_function", "escape/builtins_through_module"),
    "frames of generators and tracebacks": ("escape/generator_frame", "escape/traceback_frame"),
    "decorators and descriptors": ("escape/decorator", "escape/descriptor"),
    "__reduce__": ("escape/reduce", "escape/reduce_left_behind"),
    "ctypes through numpy": ("read/ctypes_through_numpy",),
    "np.load, np.memmap, np.fromfile": ("read/load_pickle", "read/memmap", "read/fromfile"),
    "hooks of warnings and codecs": ("escape/warning_hook", "escape/codec_hook"),
    "signal handlers": ("process/alarm", "process/deaf_to_signals"),
    "atexit": ("process/exit_hook",),
    "threads": ("process/threads", "process/thread_left"),
    "self.data": ("cheat/write_positions", "cheat/write_velocities"),
    "the framework's own objects": ("cheat/patch_numpy", "cheat/patch_robomore"),
}


def test_the_known_escapes_are_tried_and_many_more() -> None:
    names = {attempt.name for attempt in attempts()}
    assert len(names) >= 120
    for way, tried in KNOWN_ESCAPES.items():
        assert set(tried) <= names, way


def _fitness(contained: SandboxResult, planted: World, attempt: Attempt) -> float:
    """Return what the parent measures, minus infinity where it refuses what was left behind."""
    try:
        msgspec.json.decode(contained.reply, type=Claims)
        return measure(planted.root / "scratch" / attempt.name.replace("/", "-"))
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return float("-inf")
