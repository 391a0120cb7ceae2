"""The list of commands, and how every error ends: one line, an exit status, no traceback."""

from __future__ import annotations

import logging
import os
import signal
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os.path import expanduser
from types import FrameType

from cyclopts import App, CycloptsError, UnusedCliTokensError

from robomore import __version__
from robomore.cli.flowing_help import FlowingHelp
from robomore.cli.output import tell
from robomore.errors import InputError, Interrupted, RoboMoReError

COMMANDS = {
    "tasks": ("robomore.cli.tasks:tasks", "List the tasks."),
    "inspect": ("robomore.cli.tasks:inspect", "Show one robot: volume, mass, MJCF, a picture."),
    "new": ("robomore.cli.own_robot:new", "Make a task from a robot's MJCF or URDF file."),
    "check-task": ("robomore.cli.own_robot:check_task", "Say what is wrong with a task."),
    "run": ("robomore.cli.run:run", "Search for the best morphology and reward for a task."),
    "show": ("robomore.cli.show:show", "Show a run: champion, reference, how it got there."),
    "play": ("robomore.cli.play:play", "Watch a champion move, in a window or as a video."),
    "report": ("robomore.cli.show:report", "Write a run's report as one HTML file."),
    "serve": ("robomore.cli.serve:serve", "Show the runs of a folder live in a browser."),
    "audit": ("robomore.cli.audit:audit", "Check whether a champion's number can be believed."),
    "gallery": ("robomore.cli.gallery:gallery", "Keep the champions of runs in one folder."),
    "methods": ("robomore.cli.methods:methods", "List the search methods and their options."),
    "study": ("robomore.cli.study:study", "Run several methods on several tasks, with tables."),
    "compare": ("robomore.cli.tables:compare", "Put runs side by side."),
    "export": ("robomore.cli.export:export", "Take a run's champion, or its table, elsewhere."),
    "evaluate": ("robomore.cli.evaluate:evaluate", "Train and measure one design."),
    "check-reward": (
        "robomore.cli.sandbox:check_reward",
        "Check a reward, and try it out in the sandbox.",
    ),
    "doctor": ("robomore.cli.sandbox:doctor", "Check which sandbox layers this machine offers."),
    "cluster": ("robomore.cli.cluster:cluster", "Write the batch script for a cluster (Slurm)."),
    "llm": ("robomore.cli.llm:llm", "Ask a language model whether it can design."),
    "prompt": ("robomore.cli.prompt:prompt", "Print what a language model would be told."),
}
"""Name -> (`module:function`, one line of help), in the order in which they are shown."""

DONE, FAILED, MISUSED, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses: all well; the work failed; nothing was started; stopped by the user."""


def application(used: str = "") -> App:
    """Return the application with all commands; their modules are not loaded yet.

    Args:
        used: name of the command that is run; its `--help` says more than one line.
    """
    app = App(
        name="robomore",
        help="Search for a robot's morphology and its reward together. Each design is trained in "
        "MuJoCo.\n\n`--debug` with any command shows where an error came from.",
        version=__version__,
        version_flags=["--version", "-V"],
        # Markdown would be rendered by a library that takes longer to load than all else.
        help_format="plaintext",
        help_formatter=FlowingHelp(),
        # `main` says how a command that is stopped ends.
        suppress_keyboard_interrupt=False,
    )
    app.register_install_completion_command()
    for position, (name, (target, help_line)) in enumerate(COMMANDS.items()):
        app.command(target, name=name, help=None if name == used else help_line, sort_key=position)
    return app


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit status.

    Args:
        arguments: of the command line; those of this process by default.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given
    given = [_with_home(argument) for argument in given if argument != "--debug"]
    try:
        with _sigterm_as_ctrl_c(), _warnings_as_lines():
            status = application(given[0] if given else "")(
                given, exit_on_error=False, print_error=False, result_action="return_value"
            )
        return status if isinstance(status, int) else DONE
    except (Exception, KeyboardInterrupt) as error:  # noqa: BLE001  # no traceback for users
        if debug:
            tell(traceback.format_exc())
        message, status = _ending(error, given)
        if message:
            tell(f"robomore: {message}\n")
        return status


def _with_home(argument: str) -> str:
    """Return an argument with `~` as the home folder, which a shell leaves as it is after `=`."""
    option, equals, value = argument.partition("=")
    if equals and option.startswith("--") and value.startswith("~"):
        return f"{option}={expanduser(value)}"  # noqa: PTH111
    return expanduser(argument) if argument.startswith("~") else argument  # noqa: PTH111


def _ending(error: BaseException, given: Sequence[str]) -> tuple[str, int]:
    """Return the one line that an error is told in, and the exit status."""
    match error:
        case UnusedCliTokensError(unused_tokens=[first, *_]):
            return (
                f"{first!r} is one word too many. See `robomore {_command(given)}--help`.",
                MISUSED,
            )
        case CycloptsError():
            return f"{_one_line(error)} See `robomore {_command(given)}--help`.", MISUSED
        case InputError():
            return _one_line(error), MISUSED
        case Interrupted():
            return _one_line(error), INTERRUPTED
        case KeyboardInterrupt():
            return "stopped", INTERRUPTED
        case BrokenPipeError():
            # Whoever read the output (`head`) has had enough of it.
            return "", FAILED
        case RoboMoReError() | OSError():
            return _one_line(error), FAILED
        case _ if _is_interrupted(error):
            return "stopped", INTERRUPTED
        case ModuleNotFoundError(name=str(missing)) if not missing.startswith("robomore"):
            return (
                f"the package {missing!r} is missing; install RoboMoRe anew into this "
                "environment (pip install . in its folder), which installs what it needs",
                FAILED,
            )
    if _is_from_opengl(error):
        from robomore.envs.opengl import why_none

        return f"no OpenGL: {why_none()}", MISUSED
    return (
        f"a fault of RoboMoRe itself: {type(error).__name__}: {_one_line(error)}; "
        "run it again with --debug to see where",
        FAILED,
    )


def _command(given: Sequence[str]) -> str:
    return f"{given[0]} " if given and given[0] in COMMANDS else ""


def _is_interrupted(error: BaseException | None) -> bool:
    """Return whether Ctrl-C is behind an error: packages turn it into another as they load."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _is_from_opengl(error: BaseException) -> bool:
    """Return whether a driver that is asked for by name is behind an error, at import even."""
    files = [frame.filename for frame in traceback.extract_tb(error.__traceback__)]
    return "MUJOCO_GL" in os.environ and any("/OpenGL/" in file for file in files)


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())


class _Lines(logging.Handler):
    """Writes a warning as one line."""

    def emit(self, record: logging.LogRecord) -> None:
        said = " ".join(record.getMessage().split())
        tell(f"robomore: {record.levelname.lower()}: {said}\n")


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Show what the library warns of while a command runs."""
    log, lines = logging.getLogger("robomore"), _Lines(logging.WARNING)
    log.addHandler(lines)
    try:
        yield
    finally:
        log.removeHandler(lines)


@contextmanager
def _sigterm_as_ctrl_c() -> Iterator[None]:
    """Let SIGTERM end a command as Ctrl-C does: cleanly, and saying how to go on."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGTERM, interrupt)
    except ValueError:  # Not in the main thread, where signals do not arrive anyway.
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
