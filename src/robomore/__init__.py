"""RoboMoRe: co-design of robot morphology and reward, proposed, trained in MuJoCo, and refined.

A `Task` says what is to be done and which dimensions of its robot are free. A `Morphology`
(numbers) and a `Reward` (program text) make a `Design`, the unit that is trained; what training
gave is an `Evaluation`. A designer proposes, a search method decides, and what they leave behind is
a `Run`.

    import robomore

    run = robomore.run("half-cheetah", "quick", seed=0)
    run.champion.efficiency     # m/m³, over the training seeds of the final
    run.to_dataframe()          # one row an evaluation
    robomore.compare([run, "runs/another"]).to_dataframe()
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from robomore.post_import import after_import
from robomore.release import VERSION

if TYPE_CHECKING:
    from robomore.experiment import evaluate, run
    from robomore.runs import Comparison, Run, compare, load_run
    from robomore.settings import RunSettings, preset
    from robomore.tasks import TASKS, Task, get_task
    from robomore.types import Design, Evaluation, Morphology, Reward

__version__ = VERSION

__all__ = [
    "TASKS",
    "Comparison",
    "Design",
    "Evaluation",
    "Morphology",
    "Reward",
    "Run",
    "RunSettings",
    "Task",
    "compare",
    "evaluate",
    "get_task",
    "load_run",
    "preset",
    "run",
]

_HOMES = {
    "TASKS": "robomore.tasks",
    "Task": "robomore.tasks",
    "get_task": "robomore.tasks",
    "Design": "robomore.types",
    "Evaluation": "robomore.types",
    "Morphology": "robomore.types",
    "Reward": "robomore.types",
    "RunSettings": "robomore.settings",
    "preset": "robomore.settings",
    "Comparison": "robomore.runs",
    "Run": "robomore.runs",
    "compare": "robomore.runs",
    "load_run": "robomore.runs",
    "evaluate": "robomore.experiment",
    "run": "robomore.experiment",
}


def __getattr__(name: str) -> Any:
    # Loaded when first used: `import robomore` itself imports nothing heavy.
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


# `gymnasium.make("robomore/Ant-v0")` works in whichever order both are imported.
after_import("gymnasium", "robomore.envs.registration")
