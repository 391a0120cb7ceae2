"""Did the task's bounds decide the design?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.runs.bounds import at_bounds
from robomore.store.audit import Verdict


def check(subject: Subject) -> Verdict:
    """Name the parameters that stand at a bound."""
    found = at_bounds(subject.task, subject.parameters)
    count = len(subject.task.parameters)
    said = f"{len(found)} of {count} parameters stand at a bound"
    if found:
        said += f": {', '.join(found)}. With other bounds it would be another design"
    return Verdict(
        "parameters at bounds",
        "warns" if found else "passes",
        f"{said}.",
        {"at_bounds": float(len(found)), "parameters": float(count)},
    )
