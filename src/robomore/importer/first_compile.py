"""What MuJoCo compiles for the first time is compiled in a process with limits.

A few characters of MJCF can stand for millions of parts, or for a simulation of a year that
MuJoCo runs while it compiles, and its parser may crash. Nobody can count all of that beforehand.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from importlib.util import find_spec
from operator import attrgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from robomore.errors import InputError
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.tasks.portable import task_from_content
from robomore.types import Limits, Status

if TYPE_CHECKING:
    import mujoco

LIMITS = Limits(wall_seconds=60.0, memory_bytes=2 * 2**30, file_bytes=2**20)
"""What a first compilation may use. Robots of some hundred parts take less than a second."""

MOST = {
    "links": ("nbody", 500),
    "degrees of freedom": ("nv", 500),
    "solids": ("ngeom", 2_000),
    "sites": ("nsite", 2_000),
    "motors": ("nu", 500),
    "sensors": ("nsensor", 2_000),
    "tendons": ("ntendon", 500),
    "vertices of meshes": ("nmeshvert", 300_000),
    "bytes of working memory": ("narena", 2**28),
    "iterations of the solver": ("opt.iterations", 1_000),
    "iterations of the line search": ("opt.ls_iterations", 1_000),
    "iterations of the friction solver": ("opt.noslip_iterations", 1_000),
    "iterations for a collision": ("opt.ccd_iterations", 1_000),
    "starts for a collision": ("opt.sdf_initpoints", 1_000),
    "steps for a collision": ("opt.sdf_iterations", 1_000),
    "pixels in width": ("vis.global_.offwidth", 8_192),
    "pixels in height": ("vis.global_.offheight", 8_192),
    "pixels of a shadow": ("vis.quality.shadowsize", 8_192),
    "samples of a pixel": ("vis.quality.offsamples", 64),
}
"""How much a robot may have, and what of MuJoCo's model says how much it has. A humanoid with hands
has some hundred links; each step of a simulation takes time for all of it."""

_SHORTEST_STEP, _LONGEST_STEP = 1e-5, 0.1
"""Time step in s that MuJoCo can be given."""

_COMPILED: set[bytes] = set()
"""Digests of what can be compiled, as far as this process knows."""


def compile_first(name: str, function: str, payload: bytes, content: bytes) -> None:
    """Call a function that compiles something, in a process with limits, once for each content.

    Args:
        name: of what is compiled, for the message.
        function: `module:name` of a function that returns what `answer` does.
        payload: passed to the function.
        content: what is compiled.

    Raises:
        InputError: it refuses the content, or needs more than `LIMITS`.
    """
    if hashlib.sha256(content).digest() in _COMPILED:
        return
    with TemporaryDirectory(prefix="robomore-") as scratch:
        result = run_sandboxed(
            function,
            payload,
            Path(scratch),
            LIMITS,
            # A robot's file names meshes and other files anywhere.
            readable=[Path("/")],
            mode=Containment.RELAXED,
        )
    if result.status is not Status.OK:
        why = {
            Status.TIMED_OUT: f"takes more than {LIMITS.wall_seconds:g} s",
            Status.OUT_OF_MEMORY: f"takes more than {LIMITS.memory_bytes >> 20:,} MiB of memory",
            Status.CRASHED: "makes MuJoCo crash",
        }.get(result.status, f"fails ({result.diagnosis[-200:]})")
        raise InputError(
            f"{name}: to compile it {why}; use fewer and simpler parts: small counts of copies, "
            "grids and height fields, meshes with fewer vertices, nothing that contains itself"
        )
    if result.reply:
        raise InputError(result.reply.decode(errors="replace"))
    can_be_compiled(content)


def can_be_compiled(content: bytes) -> None:
    """Note that a content can be compiled, so that it is not tried (again)."""
    _COMPILED.add(hashlib.sha256(content).digest())


def compile_content(content: bytes) -> None:
    """Compile the reference of a task that came out of somebody's folder, in a process with limits.

    Without MuJoCo nothing is done: nothing can be compiled later either.

    Raises:
        InputError: its template is none, or compiling it needs more than `LIMITS`.
    """
    if find_spec("mujoco") is not None:
        compile_first("the task in the folder", f"{__name__}:_compile", content, content)


def check_amounts(name: str, model: mujoco.MjModel) -> None:
    """Refuse a robot that can be compiled, but not be simulated in a reasonable time.

    Raises:
        InputError: naming what there is too much of, and the most.
    """
    for what, (attribute, most) in MOST.items():
        if (there := attrgetter(attribute)(model)) > most:
            raise InputError(f"{name} has {there:,} {what}; the most is {most:,}")
    step = float(model.opt.timestep)
    if not _SHORTEST_STEP <= step <= _LONGEST_STEP:
        raise InputError(
            f"{name} has a time step of {step:g} s; give one from {_SHORTEST_STEP:g} to "
            f"{_LONGEST_STEP:g} s (<option timestep>)"
        )
    if not np.isfinite((*model.opt.gravity, *model.opt.wind, *model.opt.magnetic)).all():
        raise InputError(f"{name} has a gravity, wind or magnetic field that is no finite number")


def answer(work: Callable[[], object]) -> bytes:
    """Return why `work` refuses what it got, or nothing if it does not.

    Raises:
        MemoryError: MuJoCo had too little memory, or did not say why it failed.
    """
    try:
        work()
    except InputError as error:
        if "allocate memory" in str(error):
            raise MemoryError from None
        return str(error).encode(errors="replace")
    except RecursionError:
        return b"its parts are nested too deeply; attach them to fewer others"
    except RuntimeError as error:
        # Its bindings turn a failed allocation into an "unknown exception".
        raise MemoryError(str(error)) from None
    return b""


def _compile(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Compile the reference of a task; runs in the process with limits."""
    from robomore.envs.compile import compile_model

    task = task_from_content(payload, trusted=False)
    return answer(lambda: check_amounts(task.id, compile_model(task, task.reference)))
