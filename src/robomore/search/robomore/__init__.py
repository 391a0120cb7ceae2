"""The paper's method: a diverse coarse grid, then fine refinement of the best (paper, Alg. 1).

`method` is the algorithm on one screen, `coarse` and `fine` are its halves, and `screening` keeps
training for the pairs of the grid that deserve it.
"""

from robomore.search.robomore.method import RoboMoRe
from robomore.search.robomore.settings import RoboMoReSettings, Rung

__all__ = ["RoboMoRe", "RoboMoReSettings", "Rung"]
