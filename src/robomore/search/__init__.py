"""The search decides what to try next; it knows nothing of robots, trainers or files.

Each method is straight-line code over two things that it is given: a `Designer`, which proposes,
and `evaluate`, which measures a batch and answers in the same order. `robomore` is the paper's
algorithm, made of `coarse` and `fine`; `final` retrains its winner next to the human design.
"""

from robomore.search.coarse import coarse
from robomore.search.final import final
from robomore.search.fine import fine
from robomore.search.robomore import robomore

__all__ = ["coarse", "final", "fine", "robomore"]
