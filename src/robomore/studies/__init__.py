"""Studies: grids of runs, with tables and figures that put them side by side.

A `Study` names its arms (what is compared, as options of a run), its tables and its figures. A
`Cell` is one arm on one task with one seed, and an ordinary run in a folder of its own: `robomore
show` reads it, and a study that was stopped goes on with the cells that are missing.
"""

from robomore.studies.execute import run_study
from robomore.studies.registry import STUDIES
from robomore.studies.study import Arm, Cell, Results, Study
from robomore.studies.table import Table

__all__ = ["STUDIES", "Arm", "Cell", "Results", "Study", "Table", "run_study"]
