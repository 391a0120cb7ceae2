"""Does the robot keep going when its sensors and its motors are not exact?"""

from __future__ import annotations

from robomore.audit.retained import retained
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.store.audit import Verdict

OBSERVATION, ACTION = 0.05, 0.1
"""Standard deviations: of each observation as a fraction of its own spread, which is what cheap
sensors have, and of each action as a fraction of its limit."""
WARNS_BELOW = 0.5
"""Fraction of the distance that is left. Policies were trained without noise, so that losing some
says little, and it never fails a design."""


def check(subject: Subject) -> Verdict:
    """Add noise to the observations, and to the actions."""
    return retained(
        subject,
        "observation and action noise",
        {
            f"{100 * OBSERVATION:.0f} % observation noise": Variant(observation_noise=OBSERVATION),
            f"{100 * ACTION:.0f} % action noise": Variant(action_noise=ACTION),
        },
        warns_below=WARNS_BELOW,
    )
