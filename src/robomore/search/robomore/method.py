"""RoboMoRe: coarse-to-fine optimisation of morphology and reward together (paper, Alg. 1)."""

from __future__ import annotations

from typing import ClassVar

from robomore.designers.designer import Designer
from robomore.plan import Plan
from robomore.search.measure import Evaluate, top
from robomore.search.method import SearchContext
from robomore.search.robomore.ablation import ablated
from robomore.search.robomore.coarse import coarse
from robomore.search.robomore.fine import fine
from robomore.search.robomore.planning import planned
from robomore.search.robomore.settings import RoboMoReSettings
from robomore.search.robomore.turns import Turns
from robomore.search.starts import Kind
from robomore.types import Evaluation, finished


class RoboMoRe:
    """A grid of morphologies x rewards, then the best pairs refined by turns.

    Args:
        settings: N_M, N_R, k, bounds, and how the grid is screened.

    Raises:
        InputError: the rungs of the screening or the ablations make no sense.
    """

    Settings = RoboMoReSettings
    summary: ClassVar[str] = "the paper's coarse-to-fine search over morphologies and rewards"
    needs_designer: ClassVar[bool] = True
    provenance: ClassVar[str] = ""

    def __init__(self, settings: RoboMoReSettings) -> None:
        settings.check()
        self.settings = settings

    @property
    def starts_from(self) -> tuple[Kind, ...]:
        """What is searched, and so can begin with what is given."""
        kinds: tuple[Kind, ...] = ("morphology", "reward")
        return tuple(kind for kind in kinds if kind not in self.settings.without)

    @property
    def adds(self) -> str:
        """What is in the grid that no designer proposed."""
        settings = self.settings.reduced
        parts = []
        if settings.slim_reference == "in":
            parts.append("the reference morphology, as thin as its search rules allow")
        if settings.reference_reward == "in":
            parts.append("the reference reward")
        said = [f"The grid also has {', and '.join(parts)}."] if parts else []
        if settings.drawn_morphologies:
            said.append("Its other morphologies were drawn around the reference.")
        return " ".join(said)

    def plan(self, context: SearchContext) -> Plan:
        """Return the coarse and the fine stage, each at its largest."""
        return planned(self.settings.reduced, context.candidate)

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the refined designs, best first; the paper's answer is the first of them.

        Raises:
            NothingTrained: no pair of the grid could be trained, or none was proposed.
        """
        settings, objective = self.settings.reduced, context.objective
        designer = ablated(designer, settings, context)

        # Coarse: a grid of morphologies x rewards, made diverse by reflection.
        grid = coarse(designer, evaluate, settings, context)
        pairs = settings.morphologies * settings.rewards
        survivors = top(finished(grid), settings.survivors, objective, pairs)

        # Fine: alternate between morphology and reward until a cycle improves neither.
        close_call = settings.close_call if settings.improvement == "seeds" else 0.0
        return fine(
            designer,
            evaluate,
            survivors,
            grid,
            settings.max_cycles,
            settings.patience,
            context,
            close_call,
            Turns(adaptive=settings.order == "adaptive"),
        )
