"""Does the robot stand on its legs, or on its torso or head?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.envs.compile import compile_model
from robomore.store.audit import Verdict

WARNS_ABOVE = 0.1
"""Fraction of the ground's force on parts of the torso's body, the head among them. A robot may
roll or crawl, so it never fails; what was meant as a head and is used as a leg, is no leg."""


def check(subject: Subject) -> Verdict:
    """Look which parts carry the robot."""
    name = "a head used as a leg"
    seen = subject.inspection
    if seen is None:
        return Verdict(name, "fails", "The physics diverges.")
    if not seen.has_ground:
        return Verdict(name, "skipped", "Nothing in this task touches a ground.")
    if not seen.support:
        return Verdict(name, "skipped", "The robot never touched the ground.")
    model = compile_model(subject.task, subject.parameters)
    parts = [
        model.geom(g).name or f"geom {g}"
        for g in range(model.ngeom)
        # What is fixed to the torso by a body of its own is a part of it, too.
        if model.body_weldid[model.geom_bodyid[g]] == 1
    ]
    share = sum(seen.support.get(part, 0.0) for part in parts)
    said = ", ".join(
        f"{part} {100 * carried:.0f} %"
        for part, carried in sorted(seen.support.items(), key=lambda one: -one[1])[:4]
    )
    verb = "carry" if len(parts) > 1 else "carries"
    return Verdict(
        name,
        "warns" if share > WARNS_ABOVE else "passes",
        f"{' and '.join(parts)} {verb} {100 * share:.0f} % of the ground's force (most: {said}).",
        {"torso_share": share},
    )
