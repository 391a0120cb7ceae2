"""Runs a list of jobs, each a call of one function, and yields one outcome for each job.

`Inline` runs the jobs in this process, which is what a debugger needs. `Processes` runs them in
worker processes. A worker that dies costs the job it was running and nothing else. `thread_map` is
for calls that only wait. An executor knows nothing of robots. `EXECUTORS` names them for
`--executor`.
"""

from robomore.executors.executor import Done, Executor, Failed, Outcome
from robomore.executors.executors import EXECUTORS
from robomore.executors.thread_map import thread_map

__all__ = ["EXECUTORS", "Done", "Executor", "Failed", "Outcome", "thread_map"]
