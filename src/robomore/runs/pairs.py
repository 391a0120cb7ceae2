"""Found and reference morphology x found and reference reward: which made the difference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from robomore.runs.words import in_unit, number
from robomore.statistics.spread import FEWEST

if TYPE_CHECKING:
    from robomore.runs.run import Run
    from robomore.runs.trained import TrainedDesign


@dataclass(frozen=True, slots=True)
class Pairs:
    """The pairs of the final as a table.

    Attributes:
        morphologies: what the rows are called; one row if the search changed no morphology.
        rewards: what the columns are called; one column if the search changed no reward.
        cells: the pairs, row by row; each is named after its group.
        champion: which pair the champion is, in words.
        verdict: one sentence: what made the difference, or that it cannot be told.
        doubt: whether the verdict is a reason to doubt a half of the champion.
    """

    morphologies: tuple[str, ...]
    rewards: tuple[str, ...]
    cells: tuple[tuple[TrainedDesign, ...], ...]
    champion: str
    verdict: str
    doubt: bool


def crossed_pairs(run: Run) -> Pairs | None:
    """Return the pairs of a run's final; `None` before it, or if it had one pair only."""
    found, reference = run.found, run.reference
    morphology_only, reward_only = run.morphology_only, run.reward_only
    if not found or not reference or not morphology_only or not reward_only:
        return None
    same_reward = found.design.reward.source == reference.design.reward.source
    same_morphology = found.parameters == reference.parameters
    if same_reward and same_morphology:
        return None
    morphologies: tuple[str, ...] = ("found morphology", "reference morphology")
    rewards: tuple[str, ...] = ("found reward", "reference reward")
    cells: tuple[tuple[TrainedDesign, ...], ...]
    if same_reward:
        rewards, cells = rewards[1:], ((found,), (reference,))
    elif same_morphology:
        morphologies, cells = morphologies[1:], ((found, reference),)
    else:
        cells = ((found, morphology_only), (reward_only, reference))
    verdict, doubt = _verdict(run, cells)
    champion = next(
        (
            f"the {morphology} under the {reward}"
            for morphology, row in zip(morphologies, cells, strict=True)
            for reward, cell in zip(rewards, row, strict=True)
            if cell.name == run.champion_role
        ),
        "",
    )
    return Pairs(morphologies, rewards, cells, champion, verdict, doubt)


def _verdict(run: Run, cells: tuple[tuple[TrainedDesign, ...], ...]) -> tuple[str, bool]:
    """Return what made the difference, and whether that is a reason to doubt."""
    champion = run.champion_role
    if champion == "reference":
        return "Nothing that was found beats the reference design at this budget.", True
    scores = {cell.name: cell.score(run.objective) for row in cells for cell in row}
    known = {name: one for name, one in scores.items() if one and len(one.values) >= FEWEST}
    if len(known) < len(scores) or champion not in known:
        return (
            f"It cannot be told what made the difference: that takes {FEWEST} training seeds of "
            "each pair.",
            True,
        )

    def better(one: str, other: str) -> bool:
        return min(known[one].values) > max(known[other].values)

    def alike(one: str, other: str) -> str:
        mean = in_unit(known[other].mean, run.objective, run.fitness_unit)
        return f"({number(known[one].mean)} against {mean}, and their seeds overlap)"

    if not better(champion, "reference"):
        return (
            "No difference can be told between the champion and the reference design "
            f"{alike(champion, 'reference')}.",
            True,
        )
    if len(cells[0]) == 1:
        return "The morphology made the difference: the reward is the reference reward.", False
    if len(cells) == 1:
        return "The reward made the difference: the morphology is the reference morphology.", False
    if champion == "morphology_only":
        return (
            "The morphology made the difference: the champion is trained under the reference "
            "reward, and the found reward does no better on the same morphology.",
            True,
        )
    if champion == "reward_only":
        return (
            "The reward made the difference: the champion has the reference morphology, and the "
            "found morphology does no better under the same reward.",
            True,
        )
    by_morphology = better("found", "reward_only")
    by_reward = better("found", "morphology_only")
    if by_morphology and by_reward:
        return (
            "Both made a difference: with the reference reward or with the reference morphology in "
            "its place, the found pair does worse.",
            False,
        )
    if by_morphology:
        return (
            "The morphology made the difference: on the found morphology, no difference can be "
            "told between the found reward and the reference reward "
            f"{alike('found', 'morphology_only')}.",
            True,
        )
    if by_reward:
        return (
            "The reward made the difference: under the found reward, no difference can be told "
            "between the found morphology and the reference morphology "
            f"{alike('found', 'reward_only')}.",
            True,
        )
    return (
        "The found pair does better than the reference design, but it cannot be told which half "
        "made the difference: either half alone does about as well.",
        True,
    )
