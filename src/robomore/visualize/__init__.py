"""Figures of runs for a notebook or a paper: each function returns Matplotlib axes.

Every function takes a `Run` and, if you have one, the axes to draw on; without axes it makes a new
figure. Nothing is shown or saved: `ax.figure.savefig("figure.pdf")` does. Matplotlib is needed
(`pip install "robomore[plot]"`) and imported when the first figure is drawn.

    from robomore import load_run
    from robomore.visualize import best_so_far

    best_so_far(load_run("runs/demo")).figure.savefig("best.pdf")
"""

from robomore.visualize.designs import learning_curve, pairs, parameters
from robomore.visualize.search import best_so_far, fitness_over_volume, heatmap

__all__ = [
    "best_so_far",
    "fitness_over_volume",
    "heatmap",
    "learning_curve",
    "pairs",
    "parameters",
]
