"""`robomore prompt`: prints the prompts for a language model, without one."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from robomore.cli.completion import TASK
from robomore.cli.output import write, write_json
from robomore.cli.run_options import DEFAULT_PRESET
from robomore.cli.whole import Whole
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.settings import RunSettings
    from robomore.tasks import Task
    from robomore.types import Curve, Evaluation, Morphology, Reward


def prompt(
    task: Annotated[str, TASK],
    kind: Literal["morphology", "reward", "improve-morphology", "improve-reward"],
    /,
    *,
    source: Annotated[Path | None, Parameter("--from")] = None,
    objective: Literal["efficiency", "fitness", "transport-economy"] | None = None,
    history_tokens: Whole | None = None,
    history_rule: str | None = None,
    hint: str = "",
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> None:
    """Print exactly what would be sent to a language model, by default in a `quick` run.

    Parameters
    ----------
    task
        Id of a task (`robomore tasks` lists them), or the path of a task file (.toml).
    kind
        What is asked for.
    source
        Folder of a run, whose proposals are the earlier ones and whose best design is improved.
    objective
        What the search compares; by default that of the run, or `efficiency`.
    history_tokens
        The most tokens that the history may take; by default those of the run, or 4000.
    history_rule
        How entries of the history are chosen; by default as in the run.
    hint
        A remark of yours, as `robomore run --hint` takes it.
    as_json
        Print JSON: the messages, and the schema that a provider may enforce.
    """
    from robomore.designers.llm.history import HistorySettings
    from robomore.designers.llm.prompting import morphology_schema, render, render_prompt
    from robomore.experiment.training_facts import training_facts
    from robomore.settings import preset
    from robomore.tasks import get_task

    chosen = get_task(task)
    seen = _Seen() if source is None else _seen(chosen, source)
    if seen.best is None and kind.startswith("improve"):
        raise InputError(
            f"the prompt {kind!r} improves on something measured; name a run that has trained "
            "something with --from RUN"
        )
    given = {"tokens": history_tokens, "rule": history_rule}
    history = replace(
        HistorySettings(),
        **seen.history | {name: value for name, value in given.items() if value is not None},
    )
    messages = render_prompt(
        chosen,
        kind,
        objective=objective or seen.objective,
        earlier=seen.morphologies if kind == "morphology" else seen.rewards,
        best=seen.best,
        measured=seen.measured,
        settings=history,
        training=training_facts(seen.settings or preset(DEFAULT_PRESET), chosen),
        curve_of=seen.curve_of,
        hint=hint,
    )
    if seen.vision and kind.startswith("improve"):
        role, question = messages
        messages = [role, replace(question, text=f"{question.text}\n\n{render('pictures')}")]
    schema = morphology_schema(chosen) if kind.endswith("morphology") else None
    if as_json:
        sent = [{"role": message.role, "text": message.text} for message in messages]
        write_json({"messages": sent, "schema": schema})
        return
    for message in messages:
        write(f"--- {message.role} ---\n{message.text}\n")
    if schema is not None:
        write(f"--- schema ---\n{json.dumps(schema, indent=2)}\n")


@dataclass(frozen=True)
class _Seen:
    """What the prompts need of a run."""

    objective: Literal["efficiency", "fitness", "transport-economy"] = "efficiency"
    morphologies: list[Morphology] = field(default_factory=list)
    rewards: list[Reward] = field(default_factory=list)
    best: Evaluation | None = None
    measured: list[Evaluation] = field(default_factory=list)
    history: dict[str, Any] = field(default_factory=dict)
    vision: bool = False
    settings: RunSettings | None = None
    curve_of: Callable[[str], Curve | None] = lambda key: None


def _seen(task: Task, path: Path) -> _Seen:
    """Return what the next proposal would be shown of a run.

    Raises:
        InputError: it is no run of this task.
    """
    from robomore.runs import load_run
    from robomore.runs.lineage import best_of

    run = load_run(path)
    if run.manifest.task != task.id:
        raise InputError(f"{path} is a run of {run.manifest.task!r}, not of {task.id!r}")
    searched = [*run.searched, *run.cut]
    searched.sort(key=lambda record: run.plan.position(record.place))
    best = best_of((record.evaluation for record in run.searched), run.objective)
    # A refinement sees all first ideas, and what was made in its own branch.
    refined = [record.place for record in searched if record.place.parent]
    branch = next(
        (r.place.index[:1] for r in searched if r.place in refined and r.evaluation == best),
        refined[0].index[:1] if refined else (),
    )
    settings = run.manifest.designer_settings
    first = [p for p in run.proposals if not p.slot.improves and settings.get("diversity", True)]
    first.sort(key=lambda proposal: proposal.slot.index)
    return _Seen(
        run.objective,
        [p.morphology for p in first if p.morphology],
        [p.reward for p in first if p.reward],
        best,
        [
            record.evaluation
            for record in searched
            if not record.place.parent or record.place.index[:1] == branch
        ],
        settings.get("history", {}),
        bool(settings.get("vision")),
        run.manifest.settings,
        run.curve,
    )
