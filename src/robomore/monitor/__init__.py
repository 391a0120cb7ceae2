"""Monitor: from the events of a run to its state now, for whoever shows it.

`RunState` is an observer that remembers, for any search method: what is measured, what is the best
so far, and how long it still takes. The terminal and a page read the same state, so they cannot
disagree.
"""

from robomore.monitor.state import Running, RunState

__all__ = ["RunState", "Running"]
