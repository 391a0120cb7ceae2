"""What one candidate does is nothing to another that runs at the same time."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from attempts import attempts
from miniature import POLICY, measure
from test_hostile import HONEST, LIMITS
from world import World, encode, world

from robomore.sandbox.contain import run_contained
from robomore.sandbox.layers import strict_is_possible
from robomore.types import Status

pytestmark = pytest.mark.skipif(
    not strict_is_possible(), reason="this machine cannot contain a stranger"
)

WORST = (
    *("cheat/patch_numpy", "cheat/forged_reply", "escape/small_integers"),
    *("write/neighbour_policy", "broken/global_random", "availability/stderr_gigabyte"),
    *("process/kill_all", "availability/big_file", "availability/slow_sort"),
)


def honest(planted: World, name: str) -> tuple[bytes, bytes, float]:
    scratch = planted.scratch(name)
    contained = run_contained("miniature:train", encode(HONEST), scratch, LIMITS)
    assert contained.status is Status.OK, contained.diagnosis
    return contained.reply, Path(scratch / POLICY).read_bytes(), measure(scratch)


def test_numbers_stay_the_same() -> None:
    with world() as planted, ThreadPoolExecutor(2) as pool:
        alone = honest(planted, "alone")
        for attempt in attempts():
            if attempt.name not in WORST:
                continue
            stranger = pool.submit(
                run_contained,
                "miniature:train",
                encode(planted.address(attempt.source)),
                planted.scratch(attempt.name),
                LIMITS,
            )
            beside = pool.submit(honest, planted, "beside")
            assert beside.result() == alone, attempt.name
            stranger.result()
        assert honest(planted, "after") == alone
