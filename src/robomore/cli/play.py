"""`robomore play`: trained designs in motion, in a window where there is one, else as a video."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robomore.cli.inputs import positive, seed_number
from robomore.cli.output import console, tell, write
from robomore.cli.whole import Whole


def play(
    design: Path,
    /,
    *,
    evaluation: str | None = None,
    reference: Annotated[bool, Parameter(negative="")] = False,
    beside: Annotated[bool, Parameter(negative="")] = False,
    out: Path | None = None,
    seconds: Whole = 15,
    seed: Whole = 0,
    drawn: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Watch a champion, or any other design of a run, move.

    Parameters
    ----------
    design
        A run's folder, or a folder with `design.json` and `policy.npz` (a run's `champion/`, or
        what `robomore evaluate --out` left).
    evaluation
        Key of one of the run's evaluations, or its beginning, instead of the champion.
    reference
        Play the reference design of the run's final instead of the champion.
    beside
        Show the reference design below it, both at one clock and one scale. This is always a
        video.
    out
        Write a video into this file (.webp, .gif, or .mp4 with `pip install "robomore[video]"`)
        instead of opening a window. Where no window can be opened, a video is written into the
        folder of the run or of the design.
    seconds
        What is shown of the episode at most, in a window too; the distance that is told is that of
        these seconds.
    seed
        Seed of the episode's start.
    drawn
        Draw the video without OpenGL, even where OpenGL works.
    """
    from robomore.cli.trained_design import described, find_policies
    from robomore.rendering.video import default_path, refuse_format, write_video

    positive(seconds=seconds)
    seed_number(seed)
    if out is not None:
        refuse_format(out)
    policies = find_policies(design, evaluation, reference, beside)
    shown = [policy.recorded(seed).first(seconds) for policy in policies]
    if out is None and not drawn and not beside and _has_screen():
        from robomore.rendering.window import show_in_window

        write(f"{described(shown[0])}; close the window to end\n")
        sys.stdout.flush()
        if show_in_window(shown[0]):
            return
        tell("no window could be opened; writing a video instead\n")
    name = policies[0].name + ("-beside" if beside else "")
    path = out or default_path(policies[0].folder, name)
    refuse_format(path)
    tell(f"writing {path} …\n")
    with _progress() as progress:
        why_drawn = write_video(shown, path, seconds, drawn, progress)
    if why_drawn and not drawn:
        tell(f"drawn without OpenGL, because {why_drawn}\n")
    for one in shown:
        write(f"{described(one)}\n")
    write(f"video: {path}\n")


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """Show a bar in a terminal, and nothing elsewhere."""
    from rich.progress import Progress

    screen = console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("frames", total=None)

        def progress(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield progress


def _has_screen() -> bool:
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
