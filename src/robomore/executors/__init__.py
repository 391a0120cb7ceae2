"""Where evaluations run: a function, a list of jobs, and processes. Knows nothing of robots.

`Inline` calls the function here, `Processes` keeps one worker process per slot. Both answer with
one outcome per job; a worker that dies costs the job it had and nothing else. `thread_map` is for
calls that only wait.
"""

from robomore.executors.executor import Done, Executor, Failed, Outcome
from robomore.executors.inline import Inline
from robomore.executors.processes import Processes
from robomore.executors.thread_map import thread_map

__all__ = ["Done", "Executor", "Failed", "Inline", "Outcome", "Processes", "thread_map"]
