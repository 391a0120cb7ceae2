"""Statistics as pure functions: numbers in, numbers out, and always the same for the same numbers.

`spread` is for one design over its training seeds, `aggregate` for methods over tasks and runs
(rliable's formulas), `diversity` for proposals, `pareto` for designs with several objectives.
"""

from robomore.statistics.aggregate import (
    interquartile_mean,
    mean_of_all,
    probability_of_improvement,
    stratified_interval,
)
from robomore.statistics.diversity import coefficient_of_variation, self_bleu
from robomore.statistics.pareto import hypervolume, nondominated
from robomore.statistics.spread import Spread, mean_interval, ratio, spread

__all__ = [
    "Spread",
    "coefficient_of_variation",
    "hypervolume",
    "interquartile_mean",
    "mean_interval",
    "mean_of_all",
    "nondominated",
    "probability_of_improvement",
    "ratio",
    "self_bleu",
    "spread",
    "stratified_interval",
]
