"""From designs to numbers: check, compile, train, roll out, divide fitness by volume.

`evaluate` is one job, the same code here, in a worker process or on a cluster. `Evaluator` does
batches: it looks up what the ledger knows, has the rest done, and writes down each as it finishes.
"""

from robomore.evaluation.evaluate import evaluate
from robomore.evaluation.evaluator import Evaluator

__all__ = ["Evaluator", "evaluate"]
