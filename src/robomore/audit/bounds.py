"""Did the task's bounds decide the design?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.runs.bounds import at_bounds
from robomore.store.audit import Verdict


def check(subject: Subject) -> Verdict:
    """Name the parameters at the task's bounds, but for those where the reference stands there.

    A policy does not tell whether a search was held to narrower bounds; `robomore show` does.
    """
    own = dict(zip(subject.task.names, subject.parameters, strict=True))
    reference = dict(zip(subject.task.names, subject.task.reference, strict=True))
    found = [
        name for name in at_bounds(subject.task, subject.parameters) if own[name] != reference[name]
    ]
    count = len(subject.task.parameters)
    said = f"{len(found)} of {count} parameters stand at a bound of the task"
    if found:
        said += f": {', '.join(found)}. With other bounds it would be another design"
    return Verdict(
        "parameters at bounds",
        "warns" if found else "passes",
        f"{said}.",
        {"at_bounds": float(len(found)), "parameters": float(count)},
    )
