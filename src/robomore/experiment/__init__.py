"""Experiment: the composition root, the only room that knows all concrete classes.

`run` puts a search together and returns the `Run` that it leaves behind; `evaluate` trains and
measures one design. Everything below gets what it needs as arguments.
"""

from __future__ import annotations

from robomore.experiment.evaluate import evaluate
from robomore.experiment.run import run

__all__ = ["evaluate", "run"]
