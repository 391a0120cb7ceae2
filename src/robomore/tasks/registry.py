"""All tasks by id: the eight of the paper, `crawler`, and those of other packages' entry points."""

from __future__ import annotations

import logging
from pathlib import Path

from robomore.errors import InputError
from robomore.registry import Registry
from robomore.tasks.ant import ANT, ANT_DESERT, ANT_JUMP, ANT_POWERED
from robomore.tasks.crawler import CRAWLER
from robomore.tasks.half_cheetah import HALF_CHEETAH
from robomore.tasks.hopper import HOPPER
from robomore.tasks.portable import task_content, task_from_content
from robomore.tasks.swimmer import SWIMMER
from robomore.tasks.task import Task
from robomore.tasks.variants import VARIANTS
from robomore.tasks.walker import WALKER

log = logging.getLogger(__name__)


def _fault(name: str, found: object) -> str:
    if not isinstance(found, Task):
        return f"is a {type(found).__name__}, no Task"
    return "" if found.id == name else f"has the id {found.id!r}; give it the name of its entry"


SUFFIX = ".toml"
"""How the name of a task file ends."""

PAPER_TASKS = (ANT, ANT_POWERED, ANT_DESERT, ANT_JUMP, HOPPER, HALF_CHEETAH, SWIMMER, WALKER)

TASKS: Registry[Task] = Registry(
    "task", "robomore.tasks", {task.id: task for task in (*PAPER_TASKS, CRAWLER)}, _fault
)
"""Tasks by id. The entry-point group is `robomore.tasks`; each entry names a `Task` by its id."""


_FROM_FILES: dict[str, Task] = {}
"""Tasks that were read from files in this process, by id."""


_ROBOTS = (".xml", ".urdf", ".mjcf")
"""Endings of robots' files."""


def get_task(id: str) -> Task:
    """Return a task by its id, of a side study too (`robomore.tasks.variants`), or by its file.

    The path of a task file ends in `.toml`.

    Raises:
        InputError: there is no such task, or its file or the package that adds it is faulty.
    """
    if id in _FROM_FILES or not id.endswith(SUFFIX):
        try:
            return known_task(id)
        except InputError:
            if id.lower().endswith(_ROBOTS):
                raise InputError(
                    f"{id} is a robot; `robomore new {id}` makes a task of it"
                ) from None
            if _is_file(inside := Path(id) / f"task{SUFFIX}"):
                raise InputError(f"{id} is a folder; name the task file, {inside}") from None
            raise
    from robomore.importer.task_file import read_task

    return remember(read_task(Path(id)))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False  # no name that a file can have


def known_task(id: str) -> Task:
    """Return a task that is installed, or was read in this process: no id is taken for a path.

    An id that stands in somebody else's folder must not name a file to be read and executed.

    Raises:
        InputError: there is no such task, or the package that adds it is faulty.
    """
    if id in VARIANTS:
        return VARIANTS[id]
    return TASKS.get(id) if id in TASKS or id not in _FROM_FILES else _FROM_FILES[id]


def carried_task(id: str, content: bytes) -> Task:
    """Return the task that travels with a request, or the installed one of that id.

    Raises:
        InputError: as `get_task`, or the content is damaged.
    """
    return task_from_content(content) if content else get_task(id)


def remember(task: Task) -> Task:
    """Make a task of a file that the user named known by its id in this process; returns it.

    The last one of an id counts: a file may be edited and read again. A warning says so. A task
    that lies in the folder of a run or a design is handed on as it is and never known by its id,
    so that no folder changes what an id means.

    Raises:
        InputError: see `refuse_taken`.
    """
    refuse_taken(task)
    before = _FROM_FILES.get(task.id)
    if before is not None and task_content(before) != task_content(task):
        log.warning(
            "two tasks with the id %r and other contents were read; from now on the id means the "
            "one read last. Give one of them another id, unless it is the same file, edited",
            task.id,
        )
    _FROM_FILES[task.id] = task
    return task


def refuse_taken(task: Task) -> None:
    """Refuse a task that came from a file and has the id of an installed one.

    Raises:
        InputError: it has the id of a task of this package, its side studies, or another package.
    """
    if task.id in VARIANTS or task.id in TASKS:
        raise InputError(
            f"the task file calls its task {task.id!r}, which is the id of another one; rename it"
        )
