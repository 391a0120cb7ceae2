"""Where evaluations run: a function, a list of jobs, and processes. Knows nothing of robots.

`Inline` calls the function here, `Processes` keeps one worker process per slot. Both answer with
one outcome per job; a worker that dies costs the job it had and nothing else. `Threads` is for
calls that only wait.
"""

from robomore.executors.executor import Done, Executor, Failed, Outcome
from robomore.executors.inline import Inline
from robomore.executors.processes import Processes
from robomore.executors.thread_map import Threads

__all__ = ["Done", "Executor", "Failed", "Inline", "Outcome", "Processes", "Threads"]
