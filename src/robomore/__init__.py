"""RoboMoRe: co-design of robot bodies and rewards, proposed, trained in MuJoCo, and refined.

`Task` (what is to be done, and the parametrised robot), `Morphology` (its numbers), `Reward`
(program text), `Design` (a body and a reward, the unit that is trained) and `Evaluation` (what
training gave) are the five nouns. A `Designer` proposes, an `Evaluator` measures, a `Search`
decides, a `Ledger` remembers, a `Report` shows.

    from robomore import evaluate, get_task, run

    get_task("ant").volume(get_task("ant").reference)
    result = run("swimmer", "quick", seed=1)
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

__version__ = "0.1.0"

__all__ = ["TASKS", "evaluate", "get_task", "run"]

_HOMES = {
    "TASKS": "robomore.tasks",
    "get_task": "robomore.tasks",
    "evaluate": "robomore.experiment",
    "run": "robomore.experiment",
}


def __getattr__(name: str) -> Any:
    # Loaded when first used: `import robomore` itself imports nothing heavy.
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


if "gymnasium" in sys.modules:
    # Who has imported Gymnasium already may want `gymnasium.make("robomore/Ant-v0")`.
    importlib.import_module("robomore.envs.registration")
