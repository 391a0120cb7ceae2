"""A reward as a list of terms and weights, its program text, and the way back from text to list."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from robomore.designers.offline.reward_term import Term
from robomore.designers.offline.reward_terms import TERMS
from robomore.designers.offline.robot_semantics import Anatomy

STYLES = ("sum", "table", "balance")
"""Ways to write the end of a program: one sum, a sum over the returned dict, bonuses less costs."""

_HEADER = "# Composed without an LLM, from: "


@dataclass(frozen=True, slots=True)
class RewardComposition:
    """Terms by name, each with its weight, in the order of the program, and its style."""

    weights: Mapping[str, float]
    style: str = "sum"

    @property
    def terms(self) -> list[Term]:
        return [TERMS[name] for name in self.weights]

    @property
    def lead(self) -> Term | None:
        """The first term that is the task itself."""
        return next((term for term in self.terms if term.part == "task"), None)

    def without(self, names: Iterable[str]) -> RewardComposition:
        """Return the recipe less some terms."""
        left = {name: w for name, w in self.weights.items() if name not in set(names)}
        return RewardComposition(left, self.style)

    def having(self, term: Term, weight: float) -> RewardComposition:
        """Return the recipe with `term` at `weight`, in the place of any other of its topic.

        A weight outside the term's range by more than half of it is brought back.
        """
        weight = rounded(min(max(weight, term.low / 2), term.high * 2))
        rivals = [other.name for other in self.terms if other.topic == term.topic]
        if term.name in rivals:
            return RewardComposition({**self.weights, term.name: weight}, self.style)
        added = {**self.without(rivals).weights, term.name: weight}
        return RewardComposition({name: added[name] for name in TERMS if name in added}, self.style)

    def source(self, body: Anatomy) -> str:
        """Return the program for one robot."""
        recipe = ", ".join(f"{name} {weight:g}" for name, weight in self.weights.items())
        lines = [
            f"{_HEADER}{recipe} ({self.style}).",
            "import numpy as np",
            "",
            "",
            "def _get_rew(self, x_velocity, action):",
            f'    """{self.idea()[:1].upper()}{self.idea()[1:]}."""',
        ]
        for term in self.terms:
            lines += [f"    {line}" for line in term.lines(body, self.weights[term.name])] + [""]
        lines += [f"    {line}" for line in _ending(self.terms, self.style)]
        return "\n".join(lines) + "\n"

    def idea(self) -> str:
        """Return the recipe in words."""
        return "; ".join(term.idea for term in self.terms)


def read(source: str, body: Anatomy) -> RewardComposition | None:
    """Return the recipe that `source` was written from, or `None` for anybody else's text.

    The first line names the recipe; it is believed only if it gives exactly this text, so that a
    program edited by hand counts as its editor's.
    """
    match = re.match(re.escape(_HEADER) + r"(.*) \((\w+)\)\.$", source.partition("\n")[0])
    if not match or match[2] not in STYLES:
        return None
    weights: dict[str, float] = {}
    for entry in match[1].split(", "):
        name, _, weight = entry.partition(" ")
        if name not in TERMS or not TERMS[name].suits(body):
            return None
        try:
            weights[name] = float(weight)
        except ValueError:
            return None
    recipe = RewardComposition(weights, match[2])
    return recipe if recipe.source(body) == source else None


def guessed(source: str, suitable: Sequence[Term]) -> RewardComposition:
    """Return the recipe nearest to a stranger's reward text, by the words it uses.

    The leading term is the first of `suitable` where none is recognised.
    """
    text = re.sub(r"#.*", "", source).replace(" ", "").lower()
    # Without the signature, which names the velocity whether it is used or not.
    text = text.replace("def_get_rew(self,x_velocity,action)", "")
    names = {name for sign, name in _SIGNS if sign in text}
    found = [term for term in suitable if term.name in names]
    if not any(term.part == "task" for term in found):
        found = [*(term for term in suitable if term.part == "task")][:1] + found
    recipe = RewardComposition({})
    for term in found:
        recipe = recipe.having(term, middle(term))
    return recipe


def middle(term: Term) -> float:
    """Return the geometric middle of a term's range of weights."""
    return rounded(math.sqrt(term.low * term.high))


def rounded(weight: float) -> float:
    """Return a weight with two significant digits, as a person would write it."""
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


_SIGNS = (
    ("x_velocity", "forward_speed"),
    ("healthy", "alive"),
    ("alive", "alive"),
    ("control_cost", "effort"),
    ("square(action)", "effort"),
    ("action**2", "effort"),
    ("contact_cost", "hard_contact"),
    ("cfrc_ext", "hard_contact"),
    ("last_action", "jerkiness"),
    ("prev_action", "jerkiness"),
    ("previous_action", "jerkiness"),
    ("smooth", "jerkiness"),
    ("upright", "upright"),
    ("energy", "power"),
    ("power", "power"),
    ("lateral", "drift"),
    ("sideways", "drift"),
    ("heading", "facing_ahead"),
    ("height", "height_gain"),
    ("z_velocity", "upward_speed"),
)
"""Words of a program without spaces -> the term that they speak for."""
