"""All tasks by id: the eight of the paper, and those that other packages add by an entry point."""

from __future__ import annotations

from robomore.registry import Registry
from robomore.tasks.ant import ANT, ANT_DESERT, ANT_JUMP, ANT_POWERED
from robomore.tasks.half_cheetah import HALF_CHEETAH
from robomore.tasks.hopper import HOPPER
from robomore.tasks.swimmer import SWIMMER
from robomore.tasks.task import Task
from robomore.tasks.variants import VARIANTS
from robomore.tasks.walker import WALKER


def _fault(name: str, found: object) -> str:
    if not isinstance(found, Task):
        return f"is a {type(found).__name__}, no Task"
    return "" if found.id == name else f"has the id {found.id!r}; give it the name of its entry"


PAPER_TASKS = (ANT, ANT_POWERED, ANT_DESERT, ANT_JUMP, HOPPER, HALF_CHEETAH, SWIMMER, WALKER)

TASKS: Registry[Task] = Registry(
    "task", "robomore.tasks", {task.id: task for task in PAPER_TASKS}, _fault
)
"""Tasks by id. The entry-point group is `robomore.tasks`; each entry names a `Task` by its id."""


def get_task(id: str) -> Task:
    """Return a task by its id, one of the side studies (`robomore.tasks.variants`) too.

    Raises:
        InputError: there is no such task, or the package that adds it is broken.
    """
    return VARIANTS.get(id) or TASKS.get(id)
