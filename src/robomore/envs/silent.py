"""Keeps MuJoCo's own warnings off the terminal where a command tells of divergence itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def silent_mujoco() -> Iterator[None]:
    """Keep MuJoCo from printing each divergence, and from writing it to a file in this folder."""
    former = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(former)
