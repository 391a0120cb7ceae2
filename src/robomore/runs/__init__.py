"""Runs as values: what a search left behind, read from its folder alone.

`load_run` gives a `Run`: its champion and reference, every evaluation, every proposal, and tables
of them. `compare` puts several runs side by side. Nothing here needs a trainer; only
`Run.load_policy` and `Run.make_env` load what moves a robot.
"""

from robomore.runs.comparison import Comparison, compare
from robomore.runs.loading import load_run
from robomore.runs.run import Run
from robomore.runs.trained import TrainedDesign
from robomore.statistics.spread import Spread

__all__ = ["Comparison", "Run", "Spread", "TrainedDesign", "compare", "load_run"]
