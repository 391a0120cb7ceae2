"""What one candidate does is nothing to another that runs at the same time."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from attempts import attempts
from miniature import POLICY, measure
from test_hostile import HONEST, LIMITS
from world import World, encode, world

from robomore.sandbox.call import run_sandboxed
from robomore.training.checkpoint import load_checkpoint
from robomore.types import Status
from strict import strictly

pytestmark = strictly

WORST = (
    *("cheat/patch_numpy", "cheat/forged_reply", "escape/small_integers"),
    *("write/neighbour_policy", "broken/global_random", "availability/stderr_gigabyte"),
    *("process/kill_all", "availability/big_file", "availability/slow_sort"),
)


def honest(planted: World, name: str) -> tuple[bytes, bytes, float]:
    scratch = planted.scratch(name)
    result = run_sandboxed("miniature:train", encode(HONEST), scratch, LIMITS)
    assert result.status is Status.OK, result.diagnosis
    return result.reply, Path(scratch / POLICY).read_bytes(), measure(scratch)


def test_numbers_stay_the_same() -> None:
    with world() as planted, ThreadPoolExecutor(2) as pool:
        alone = honest(planted, "alone")
        for name in WORST:
            hostile = pool.submit(
                run_sandboxed,
                "miniature:train",
                encode(planted.address(attempts()[name].source)),
                planted.scratch(name),
                LIMITS,
            )
            beside = pool.submit(honest, planted, "beside")
            assert beside.result() == alone, name
            hostile.result()
        assert honest(planted, "after") == alone


@pytest.mark.parametrize(
    "name", ["write/neighbour_checkpoint", "read/neighbour_checkpoint", "write/neighbour_policy"]
)
def test_a_checkpoint_of_its_own_opens_no_way_to_anothers(name: str) -> None:
    """Where a training keeps a checkpoint it may write to one folder more, and to no other."""
    with world() as planted:
        own = planted.root / "own"
        source = planted.address(attempts()[name].source)
        scratch = planted.scratch(name)
        for words in (source, source.replace(str(planted.root / "neighbour"), "../../neighbour")):
            ended = run_sandboxed("miniature:train", encode(words), scratch, LIMITS, writable=[own])
            assert ended.status is Status.REWARD_FAILED, ended.diagnosis
            assert "Permission" in ended.diagnosis or "denied" in ended.diagnosis, ended.diagnosis
            assert not planted.breaches(ended, scratch)
        assert load_checkpoint(planted.root / "neighbour") is not None
