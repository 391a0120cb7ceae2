"""Runs a list of jobs, each a call of one function, and yields one outcome for each job.

`Inline` runs the jobs in this process, `Processes` in worker processes. A worker that dies costs
the job it was running and nothing else. `Threads` is for calls that only wait. An executor knows
nothing of robots.
"""

from robomore.executors.executor import Done, Executor, Failed, Outcome
from robomore.executors.inline import Inline
from robomore.executors.processes import Processes
from robomore.executors.thread_map import Threads

__all__ = ["Done", "Executor", "Failed", "Inline", "Outcome", "Processes", "Threads"]
