"""Bayesian optimisation of the morphology: a Gaussian process, and log expected improvement.

`method` is the algorithm on one screen, `process` is the Gaussian process that it learns with.
"""

from robomore.search.bayesian.method import Bayesian, BayesianSettings

__all__ = ["Bayesian", "BayesianSettings"]
