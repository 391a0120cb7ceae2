"""How much of what a robot does is left when one thing is changed."""

from __future__ import annotations

import math
from collections.abc import Mapping

from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.runs.words import in_unit
from robomore.store.audit import Outcome, Verdict

LEAST_WORTH = 0.1
"""Fitness below which a robot gets nowhere, and has nothing to lose: in metres, for most tasks."""

NUMERICAL_GAIN = 2.0
"""Multiple of the fitness from which on it hangs on how the physics is computed, though nothing is
lost. Of two feather-light ants that jumped 14 and 16 m with RK4, implicitfast at half the timestep
made jumps of 114 and 116 m."""


def retained(
    subject: Subject,
    check: str,
    variants: Mapping[str, Variant],
    *,
    fails_below: float = 0.0,
    warns_below: float,
    warns_above: float = math.inf,
) -> Verdict:
    """Return a verdict on the variant that costs the most, and on the one that brings the most.

    Args:
        subject: what is audited.
        check: name of the check.
        variants: what is changed, by its words.
        fails_below: fraction of what the robot does that has to be left.
        warns_below: likewise, for a warning.
        warns_above: multiple of what the robot does from which on a gain is a warning, too.
    """
    base = subject.worth()
    if base is None or base < LEAST_WORTH:
        said = (
            "the physics diverges"
            if base is None
            else f"it gets {in_unit(base, 'fitness', subject.unit)}"
        )
        return Verdict(check, "skipped", f"There is nothing to lose: {said} as it is.")
    left = {name: subject.worth(variant) for name, variant in variants.items()}
    told = ", ".join(f"{name} {_words(worth, base, subject.unit)}" for name, worth in left.items())
    shares = [0.0 if worth is None else max(0.0, worth / base) for worth in left.values()]
    least = min(shares)
    outcome: Outcome = "passes"
    if least < fails_below:
        outcome = "fails"
    elif least < warns_below or max(shares) > warns_above:
        outcome = "warns"
    numbers = {_name(name): worth for name, worth in left.items() if worth is not None}
    return Verdict(
        check,
        outcome,
        f"{in_unit(base, 'fitness', subject.unit)} as it is; {told}.",
        {"base": base, **numbers, "least_left": least},
    )


def _words(worth: float | None, base: float, unit: str) -> str:
    if worth is None:
        return "lets the physics diverge"
    return f"leaves {in_unit(worth, 'fitness', unit)} ({100 * worth / base:.0f} %)"


def _name(words: str) -> str:
    return "_".join(words.replace("%", "percent").split())
