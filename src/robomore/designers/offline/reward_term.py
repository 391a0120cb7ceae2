"""One term of a reward: its purpose, its code, and its range of weights."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from robomore.designers.offline.robot_semantics import RobotSemantics

Part = Literal["task", "survival", "bonus", "cost"]


@dataclass(frozen=True, slots=True)
class Term:
    """One term of a reward.

    Attributes:
        name: name of the variable, and of the term in the returned dictionary.
        part: `task` is what the task asks for, a `bonus` suggests how, a `cost` is subtracted.
        idea: its purpose in a few words.
        comment: comment above it in the program.
        code: lines that end with an assignment to `name`. `{w}` is the weight. Other braces are
            names of `RobotSemantics.expressions`, and the term suits robots that have them all.
        low: smallest weight.
        high: largest weight.
        topic: terms with the same topic have nearly the same effect. A reward has at most one.
        needs: names of `RobotSemantics.expressions` that are needed but not in `code`.
        goal: the kind of task that it suits.
    """

    name: str
    part: Part
    idea: str
    comment: str
    code: str
    low: float
    high: float
    topic: str
    needs: tuple[str, ...] = ()
    goal: Literal["distance", "height", "any"] = "any"

    @property
    def sign(self) -> int:
        """-1 for a cost, otherwise 1."""
        return -1 if self.part == "cost" else 1

    def suits(self, robot: RobotSemantics) -> bool:
        """Return whether the robot has all that this term reads, and the task asks for it."""
        wanted = "height" if robot.jumps else "distance"
        read = {*re.findall(r"\{(\w+)\}", self.code), *self.needs} - {"w"}
        return self.goal in ("any", wanted) and read <= set(robot.expressions)

    def lines(self, robot: RobotSemantics, weight: float) -> list[str]:
        """Return its comment and code for one robot."""
        code = self.code.format_map({**robot.expressions, "w": f"{weight:g}"})
        return [f"# {self.comment}", *code.splitlines()]
