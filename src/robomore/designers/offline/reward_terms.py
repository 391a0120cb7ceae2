"""The reward terms of `reward_terms.txt`: their purpose, their code, and their range of weights."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import resources
from typing import Literal

import msgspec

from robomore.designers.offline.robot_semantics import RobotSemantics


class Term(msgspec.Struct, frozen=True):
    """One term of a reward.

    Attributes:
        name: name of the variable, and of the term in the returned dictionary.
        part: `task` is what the task asks for, and every reward has one of these as its leading
            term. A `bonus` suggests how, a `cost` is subtracted.
        topic: terms with the same topic have nearly the same effect. A reward has at most one.
        low: smallest weight.
        high: largest weight.
        goal: the kind of task that it suits.
        needs: names of `RobotSemantics.expressions` that are needed but not in `code`.
        idea: its purpose in a few words.
        comment: comment above it in the program.
        code: lines that end with an assignment to `name`. `{w}` is the weight. Other braces are
            names of `RobotSemantics.expressions`, and the term suits robots that have them all.
    """

    name: str
    part: Literal["task", "survival", "bonus", "cost"]
    topic: str
    low: float
    high: float
    goal: Literal["distance", "height", "any"]
    needs: str
    idea: str
    comment: str
    code: str

    @property
    def sign(self) -> int:
        """-1 for a cost, otherwise 1."""
        return -1 if self.part == "cost" else 1

    def suits(self, robot: RobotSemantics) -> bool:
        """Return whether the robot has all that this term reads, and the task asks for it."""
        wanted = "height" if robot.jumps else "distance"
        read = {*re.findall(r"\{(\w+)\}", self.code), *self.needs.split()} - {"w"}
        return self.goal in ("any", wanted) and read <= set(robot.expressions)

    def lines(self, robot: RobotSemantics, weight: float) -> list[str]:
        """Return its comment and code for one robot."""
        code = self.code.format_map({**robot.expressions, "w": f"{weight:g}"})
        return [self.comment, *code.splitlines()]


def suitable(robot: RobotSemantics) -> tuple[Term, ...]:
    """Return the terms that suit a robot and its task."""
    return tuple(term for term in TERMS.values() if term.suits(robot))


def _terms() -> Iterator[Term]:
    file = resources.files("robomore.designers.offline") / "reward_terms.txt"
    for block in file.read_text(encoding="utf-8").rstrip().split("\n\n")[1:]:
        head, comment, code = block.split("\n", 2)
        values = [*(value.strip() for value in head.split("|")), comment, code]
        fields = dict(zip(Term.__struct_fields__, values, strict=True))
        yield msgspec.convert(fields, Term, strict=False)


TERMS = {term.name: term for term in _terms()}
"""All terms by name. Those for the task itself come first."""
