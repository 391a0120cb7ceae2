"""Search: whoever decides what is tried next. It knows nothing of trainers, physics or files.

A `SearchMethod` is straight-line code over two things that it is given: a designer, which proposes,
and `evaluate`, which measures a batch and answers in the same order. `robomore` is the paper's
algorithm; `random` and `reference` are the simplest methods. `METHODS` names them all. `final` is
the same for every method and belongs to none: it trains the winner anew, beside the reference.
"""

from robomore.search.final import Final, final
from robomore.search.method import SearchContext, SearchMethod
from robomore.search.methods import METHODS, make_method

__all__ = ["METHODS", "Final", "SearchContext", "SearchMethod", "final", "make_method"]
