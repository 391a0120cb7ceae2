"""Where evaluations run: a function, a list of jobs, and processes. Knows nothing of robots.

`Inline` calls the function here, which is what a debugger needs. `Processes` keeps one worker
process per slot. Both answer with one outcome per job; a worker that dies costs the job it had and
nothing else. `thread_map` is for calls that only wait. `EXECUTORS` names them for `--executor`.
"""

from robomore.executors.executor import Done, Executor, Failed, Outcome
from robomore.executors.executors import EXECUTORS
from robomore.executors.thread_map import Threads as thread_map

__all__ = ["EXECUTORS", "Done", "Executor", "Failed", "Outcome", "thread_map"]
