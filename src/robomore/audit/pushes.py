"""Does the robot keep going when it is pushed?"""

from __future__ import annotations

from robomore.audit.retained import retained
from robomore.audit.subject import Subject
from robomore.audit.variant import PUSH_EVERY_SECONDS, PUSH_SECONDS, Variant
from robomore.store.audit import Verdict

WEIGHTS = 0.5
"""Force of a push in robot weights: for 0.1 s, it changes a free body's speed by 0.5 m/s, which is
a nudge that a person gives in passing."""
WARNS_BELOW = 0.5
"""Fraction of the distance that is left. Nobody was pushed in training, so it never fails."""


def check(subject: Subject) -> Verdict:
    """Push the torso backwards, and sideways in turn where it can move sideways."""
    words = (
        f"a push of {WEIGHTS:g} robot weights for {PUSH_SECONDS:g} s every {PUSH_EVERY_SECONDS:g} s"
    )
    return retained(subject, "pushes", {words: Variant(push=WEIGHTS)}, warns_below=WARNS_BELOW)
