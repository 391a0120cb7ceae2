"""One term of a reward: what it asks for, its code, and the weights that keep it in place."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from robomore.designers.offline.robot_semantics import Anatomy

Part = Literal["task", "survival", "bonus", "cost"]


@dataclass(frozen=True, slots=True)
class Term:
    """One term of a reward.

    Attributes:
        name: of the variable, and of the term in the returned dict.
        part: `task` leads; a `bonus` hints at how, a `cost` is subtracted.
        idea: what it asks for, in a few words.
        comment: stands above it in the program.
        code: lines that end in an assignment to `name`. `{w}` is the weight, other braces are names
            of `Anatomy.expressions`; the term suits robots that have them all.
        low: smallest weight.
        high: largest weight.
        topic: terms of one topic say nearly the same; a reward has at most one of them.
        needs: names of `Anatomy.expressions` that `code` does not mention.
        goal: the kind of task it suits.
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
        """-1 for a cost, else 1."""
        return -1 if self.part == "cost" else 1

    def suits(self, body: Anatomy) -> bool:
        """Whether the robot has all that this term reads, and the task wants it."""
        wanted = "height" if body.jumps else "distance"
        read = {*re.findall(r"\{(\w+)\}", self.code), *self.needs} - {"w"}
        return self.goal in ("any", wanted) and read <= set(body.expressions)

    def lines(self, body: Anatomy, weight: float) -> list[str]:
        """Return its comment and code for one robot."""
        code = self.code.format_map({**body.expressions, "w": f"{weight:g}"})
        return [f"# {self.comment}", *code.splitlines()]
