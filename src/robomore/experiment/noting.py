"""What a run notes in its ledger besides evaluations: its budgets, and the outcome of its final."""

from __future__ import annotations

from pathlib import Path

from robomore.errors import InputError
from robomore.plan import Plan
from robomore.runs.cost import trained_steps
from robomore.search import Final
from robomore.store import Ledger
from robomore.text import to_json

_BUDGET = "budget"


def note_budget(ledger: Ledger, plan: Plan, budget_steps: int | None, folder: Path) -> None:
    """Note the budget of a search, and refuse one that its folder has already gone beyond.

    A search with a smaller budget than one before it would see less than the folder shows, and the
    numbers of both would stand side by side. What was spent under the same budget is no reason to
    refuse: an evaluation that is done again after a fault of the machine may lead elsewhere.

    Raises:
        InputError: an earlier call had a larger budget and spent more than `budget_steps`.
    """
    earlier = [event.body.get("steps") for event in ledger.events() if event.kind == _BUDGET]
    if budget_steps is not None:
        searched = {
            evaluation.key: evaluation
            for place, evaluation in ledger.placed()
            if plan.stage(place.stage).role == "search"
        }
        spent = trained_steps(searched.values())
        bounds = [one for one in earlier if isinstance(one, int)]
        within = bool(earlier) and len(bounds) == len(earlier) and max(bounds) <= budget_steps
        if spent > budget_steps and not within:
            raise InputError(
                f"the search in {folder} has trained for {spent} steps already, and a budget of "
                f"{budget_steps} takes nothing back; give --budget-steps {spent} or more, or "
                "another folder (--out)"
            )
    if (earlier or budget_steps is not None) and earlier[-1:] != [budget_steps]:
        ledger.add_event(_BUDGET, steps=budget_steps)


def note_final(ledger: Ledger, outcome: Final) -> None:
    """Write down who is champion, the groups of the final by their role, and all its places."""
    groups = {
        name: [evaluation.key for evaluation in getattr(outcome, name)]
        for name in ("champion", "found", "reference", "morphology_only", "reward_only")
    }
    places = [to_json(place).decode() for place in outcome.places]
    passed_over = [
        {"keys": [evaluation.key for evaluation in group], "reason": reason}
        for group, reason in outcome.passed_over
    ]
    more = {"passed_over": passed_over} if passed_over else {}
    ledger.add_event("finished", **groups, places=places, **more)
