"""Whose turn it is in the fine stage: the morphology's or the reward's.

In the paper they take turns. Where one of them is what improves designs, half of the trainings are
then spent on the other. So the next turn can go to the kind whose latest proposals improved more.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from robomore.search.starts import Kind

KINDS: tuple[Kind, Kind] = ("morphology", "reward")
"""In the paper's order."""

_KEPT = 0.5
"""Weight of a batch of proposals against the next one of its kind: what improved designs at first
may have nothing left to improve."""


@dataclass
class Turns:
    """Chooses a kind for each batch of proposals, the same one for all branches.

    Attributes:
        adaptive: whether the kind follows from what earlier proposals brought.
    """

    adaptive: bool = False
    _improved: dict[str, float] = field(default_factory=lambda: dict.fromkeys(KINDS, 0.0))
    _tried: dict[str, float] = field(default_factory=lambda: dict.fromkeys(KINDS, 0.0))

    def kind(self, turn: int) -> Kind:
        """Return the kind of the proposals of `turn` (0, 1, …), two of which are a cycle."""
        if not self.adaptive:
            return KINDS[turn % len(KINDS)]
        return max(KINDS, key=self._rate)

    def index(self, turn: int) -> int:
        """Return the number of `turn` in slots and places: of its cycle, or its own if adaptive,
        because a cycle may then have two proposals of a kind."""
        return turn if self.adaptive else turn // len(KINDS)

    def note(self, kind: Kind, share: float) -> None:
        """Learn from a batch: the share of its branches that it improved."""
        self._improved[kind] = _KEPT * self._improved[kind] + share
        self._tried[kind] = _KEPT * self._tried[kind] + 1

    def _rate(self, kind: Kind) -> float:
        """Return the estimated share, one half before there is any evidence (Laplace)."""
        return (self._improved[kind] + 1) / (self._tried[kind] + 2)
