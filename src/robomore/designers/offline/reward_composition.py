"""A reward as a list of terms with weights, and its translation to and from program text."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from robomore.designers.offline.reward_terms import TERMS, Term
from robomore.designers.offline.robot_semantics import RobotSemantics

STYLES = ("sum", "table", "balance")
"""Ways to write the end of a program: one sum, a sum over the returned dictionary, or bonuses minus
costs."""

_HEADER = "# Composed without an LLM, from: "


@dataclass(frozen=True, slots=True)
class RewardComposition:
    """Weights by term name, in the order of the program, and the style of the program."""

    weights: Mapping[str, float]
    style: str = "sum"

    @property
    def terms(self) -> list[Term]:
        return [TERMS[name] for name in self.weights]

    @property
    def lead(self) -> Term | None:
        """The leading term: the first one that is for the task itself."""
        return next((term for term in self.terms if term.part == "task"), None)

    def without(self, names: Iterable[str]) -> RewardComposition:
        """Return the composition without some terms."""
        left = {name: w for name, w in self.weights.items() if name not in set(names)}
        return RewardComposition(left, self.style)

    def with_term(self, term: Term, weight: float) -> RewardComposition:
        """Return the composition with `term` at `weight`, instead of any other term of its topic.

        The weight is limited to half of the term's smallest and twice its largest weight.
        """
        weight = rounded(min(max(weight, term.low / 2), term.high * 2))
        rivals = [other.name for other in self.terms if other.topic == term.topic]
        if term.name in rivals:
            return RewardComposition({**self.weights, term.name: weight}, self.style)
        added = {**self.without(rivals).weights, term.name: weight}
        return RewardComposition({name: added[name] for name in TERMS if name in added}, self.style)

    def source(self, robot: RobotSemantics) -> str:
        """Return the program for one robot."""
        weights = ", ".join(f"{name} {weight:g}" for name, weight in self.weights.items())
        lines = [
            f"{_HEADER}{weights} ({self.style}).",
            "import numpy as np",
            "",
            "",
            "def _get_rew(self, x_velocity, action):",
            f'    """{self.idea()[:1].upper()}{self.idea()[1:]}."""',
        ]
        for term in self.terms:
            lines += [f"    {line}" for line in term.lines(robot, self.weights[term.name])] + [""]
        lines += [f"    {line}" for line in _ending(self.terms, self.style)]
        return "\n".join(lines) + "\n"

    def idea(self) -> str:
        """Return the terms in words."""
        return "; ".join(term.idea for term in self.terms)


def parse_composition(source: str, robot: RobotSemantics) -> RewardComposition | None:
    """Return the composition that `source` was written from, or `None` for any other text.

    The first line names the composition. It counts only if the composition gives exactly this text,
    so a program that was edited by hand counts as another text.
    """
    match = re.match(re.escape(_HEADER) + r"(.*) \((\w+)\)\.$", source.partition("\n")[0])
    if not match or match[2] not in STYLES:
        return None
    weights: dict[str, float] = {}
    for entry in match[1].split(", "):
        name, _, weight = entry.partition(" ")
        if name not in TERMS or not TERMS[name].suits(robot):
            return None
        try:
            weights[name] = float(weight)
        except ValueError:
            return None
    composition = RewardComposition(weights, match[2])
    return composition if composition.source(robot) == source else None


def guess_composition(source: str, suitable: Sequence[Term]) -> RewardComposition:
    """Return the composition nearest to any reward text, by the words in the text.

    If no leading term is recognized, it is the first of `suitable`.
    """
    text = re.sub(r"#.*", "", source).replace(" ", "").lower()
    # The signature names the velocity whether it is used or not.
    text = text.replace("def_get_rew(self,x_velocity,action)", "")
    names = {name for name, signs in _SIGNS.items() if any(sign in text for sign in signs)}
    found = [term for term in suitable if term.name in names]
    if not any(term.part == "task" for term in found):
        found = [*(term for term in suitable if term.part == "task")][:1] + found
    composition = RewardComposition({})
    for term in found:
        composition = composition.with_term(term, middle(term))
    return composition


def middle(term: Term) -> float:
    """Return the geometric mean of a term's smallest and largest weight."""
    return rounded(math.sqrt(term.low * term.high))


def rounded(weight: float) -> float:
    """Return a weight with two significant digits."""
    return float(f"{weight:.2g}")


def _ending(terms: Sequence[Term], style: str) -> list[str]:
    entries = [f'    "{t.name}": {"-" if t.sign < 0 else ""}{t.name},' for t in terms]
    table = ["terms = {", *entries, "}"]
    gains = " + ".join(term.name for term in terms if term.sign > 0)
    losses = [term.name for term in terms if term.sign < 0]
    if style == "table":
        return [*table, "return sum(terms.values()), terms"]
    if style == "balance" and losses:
        balance = [f"gain = {gains}", f"price = {' + '.join(losses)}"]
        return [*balance, *table, "return gain - price, terms"]
    return [f"reward = {' - '.join([gains, *losses])}", *table, "return reward, terms"]


_SIGNS = {
    "forward_speed": ("x_velocity",),
    "alive": ("healthy", "alive"),
    "effort": ("control_cost", "square(action)", "action**2"),
    "hard_contact": ("contact_cost", "cfrc_ext"),
    "jerkiness": ("last_action", "prev_action", "previous_action", "smooth"),
    "upright": ("upright",),
    "power": ("energy", "power"),
    "drift": ("lateral", "sideways"),
    "facing_ahead": ("heading",),
    "height_gain": ("height",),
    "upward_speed": ("z_velocity",),
}
"""Terms, and the words in a program without spaces that indicate them."""
