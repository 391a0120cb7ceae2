"""What a prompt says of each objective: the name of the score, and what it asks of a design."""

from __future__ import annotations

from dataclasses import dataclass

from robomore.tasks.fitness import Fitness


@dataclass(frozen=True, slots=True)
class ObjectiveWords:
    """The words for one objective.

    Attributes:
        name: what the score is called.
        what: what the score is, as a sentence.
        material: what it asks of the material of a morphology.
        reward: what it asks of a reward.
    """

    name: str
    what: str
    material: str
    reward: str


OBJECTIVES = {
    "efficiency": ObjectiveWords(
        "efficiency",
        "The score is the efficiency. Make it as high as you can.",
        "Every part adds to the volume, wherever it is. Weigh what each parameter adds to the "
        "volume against what it does for the motion, and spend material where it does most.",
        "A reward does not change the volume, so it is the fitness of the trained robot that your "
        "reward has to bring about.",
    ),
    "fitness": ObjectiveWords(
        "fitness",
        "The score is the fitness. Make it as high as you can.",
        "The volume does not enter the score. Material costs nothing but the effort of moving it, "
        "so give each part the size that is best for the motion.",
        "So it is the fitness of the trained robot that your reward has to bring about.",
    ),
    "transport-economy": ObjectiveWords(
        "transport economy",
        "The score is the transport economy: mass * 9.81 m/s² * forward "
        "distance / energy. It has no unit. The energy is the absolute power of the motors, summed "
        "over all of them and over an episode, in J; braking costs as much as driving. Less than "
        "1 m of distance, or less than twice the height of the torso at rest, scores 0: a fall "
        "gives that for nothing. Make the transport economy as high as you can.",
        "The volume does not enter the score. Mass counts on both sides: it is what is "
        "transported, and moving it takes energy. So choose sizes with which the robot gets far "
        "for each joule that it spends for its weight.",
        "A reward does not change the mass, so what your reward has to bring about is that the "
        "trained robot gets far with little energy, and in any case farther than 1 m and than "
        "twice the height of its torso.",
    ),
}
"""By the objective of a run (`robomore.settings.Objective`)."""


def score_label(objective: str, goal: Fitness) -> str:
    """Return the name of the score with its unit, such as `efficiency (m/m³)`."""
    unit = {"efficiency": goal.per_volume, "fitness": goal.unit}.get(objective, "no unit")
    name = OBJECTIVES[objective].name
    return f"{name} ({unit})" if unit else name
