"""Makes the prompts of the designer from the texts in `prompts/`.

Every prompt is a pure function of the task, the settings and the evaluations. So `robomore prompt`
prints exactly what is sent.
"""

from __future__ import annotations

import json
import string
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

from robomore.designers.llm.formatting import (
    evaluation_lines,
    morphology_lines,
    reward_lines,
)
from robomore.designers.llm.history import (
    CurveOf,
    HistorySettings,
    full_steps,
    morphology_entries,
    reward_entries,
    select,
)
from robomore.designers.llm.objectives import OBJECTIVES, score_label
from robomore.designers.llm.robot_facts import episode_facts, robot_layout, volume_line
from robomore.designers.llm.score_table import Numbers, score_table, spread_sentence
from robomore.designers.llm.training_facts import TrainingFacts
from robomore.errors import InputError
from robomore.llm.model import Message
from robomore.llm.tokens import estimate_tokens
from robomore.suggestions import no_such
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward

KINDS = ("morphology", "reward", "improve-morphology", "improve-reward")

_TABLE_FRACTION = 0.5
"""Part of the history's tokens that the table of all results may take."""


def render_prompt(
    task: Task,
    kind: str,
    *,
    objective: str = "efficiency",
    earlier: Sequence[Morphology | Reward] = (),
    best: Evaluation | None = None,
    measured: Sequence[Evaluation] = (),
    settings: HistorySettings | None = None,
    training: TrainingFacts | None = None,
    curve_of: CurveOf = lambda key: None,
    hint: str = "",
) -> list[Message]:
    """Return the messages that ask for one proposal.

    Args:
        task: the task to design for.
        kind: one of `KINDS`.
        objective: what the search compares.
        earlier: proposals that the new one must differ from (Diversity Reflection). Improvements
            do not use it.
        best: the evaluation to improve on. Only improvements use it.
        measured: the history. Only improvements use it.
        settings: how much of the history the prompt holds.
        training: what trains, `None` to say nothing of it.
        curve_of: returns learning curves. Only improvements use it.
        hint: remark of the person who runs the search; it comes last.

    Raises:
        InputError: there is no such kind, or nothing to improve on.
    """
    if kind not in KINDS:
        raise no_such("prompt", kind, KINDS)
    part = kind.removeprefix("improve-")
    parts = [_base(task, part, objective, training)]
    if kind != part:
        if best is None:
            raise InputError(f"the prompt {kind!r} improves on something measured: name a run")
        history = settings or HistorySettings()
        parts.append(_improve(task, part, objective, best, measured, history, curve_of))
    elif earlier:
        parts.append(_diversity(task, part, earlier))
    if hint:
        parts.append(render("hint", hint=hint))
    return [Message("system", render(f"role-{part}")), Message("user", "\n\n".join(parts))]


def repair_message(errors: Sequence[str]) -> Message:
    """Return the message that answers a reply with `errors`."""
    return Message("user", render("repair", errors="\n".join(f"- {error}" for error in errors)))


def morphology_schema(task: Task) -> dict[str, Any]:
    """Return the JSON schema of a morphology with the bounds of its parameters."""
    numbers = {
        p.name: {
            "type": "integer" if p.whole else "number",
            "minimum": int(p.low) if p.whole else p.low,
            "maximum": int(p.high) if p.whole else p.high,
        }
        for p in task.parameters
    }
    return {
        "title": "morphology",
        "type": "object",
        "properties": {
            "parameters": {
                "type": "object",
                "properties": numbers,
                "required": list(task.names),
                "additionalProperties": False,
            },
            "description": {"type": "string", "maxLength": 200},
        },
        "required": ["parameters", "description"],
        "additionalProperties": False,
    }


def render(name: str, **fields: str) -> str:
    """Return the prompt file `name` with its fields filled in.

    Raises:
        KeyError: a field of the file is not given.
        ValueError: the file has no such field.
    """
    template = _template(name)
    unused = set(fields) - set(template.get_identifiers())
    if unused:
        raise ValueError(f"prompt {name!r} has no field {', '.join(sorted(unused))}")
    return template.substitute(fields).strip()


@cache
def _template(name: str) -> string.Template:
    folder = resources.files("robomore.designers.llm") / "prompts"
    return string.Template((folder / f"{name}.md").read_text(encoding="utf-8"))


def _base(task: Task, part: str, objective: str, training: TrainingFacts | None) -> str:
    words = OBJECTIVES[objective]
    shared = {
        "description": task.description,
        "episode_steps": f"{task.episode_steps:,}",
        "fitness": _fitness(task),
        "objective": words.what,
        "training": f"{training}\n\n" if training else "",
        "episodes": episode_facts(task),
    }
    if part == "reward":
        # This imports the simulator, which nothing else in this module needs.
        from robomore.envs.source import environment_source

        return render(
            "reward",
            environment=environment_source(task).strip(),
            layout=robot_layout(task),
            asked=words.reward,
            **shared,
        )
    rows = [
        f"| {p.name} | {p.meaning}{' (a whole number)' if p.whole else ''} | {p.unit} | {p.low:g} "
        f"| {p.high:g} |"
        for p in task.parameters
    ]
    head = ["| name | meaning | unit | least | most |", "|---|---|---|---|---|"]
    rules = "Any numbers within these bounds make a valid morphology."
    if task.rules:
        rules = "A morphology also has to keep to these rules:\n\n"
        rules += "\n".join(f"- {rule.text}" for rule in task.rules)
    names = ", ".join(f"{json.dumps(name)}: …" for name in task.names)
    return render(
        "morphology",
        mjcf=task.masked_mjcf.strip(),
        material=words.material,
        parameters="\n".join([*head, *rows]),
        rules=rules,
        form=f'{{"parameters": {{{names}}}, "description": "…"}}',
        count=str(len(task.parameters)),
        **shared,
    )


def _fitness(task: Task) -> str:
    goal = task.goal
    unit = f", in {goal.unit}" if goal.unit else ""
    return f"{goal.meaning}{unit}, as a mean over several episodes"


def _diversity(task: Task, part: str, earlier: Sequence[Morphology | Reward]) -> str:
    shown = []
    for number, proposal in enumerate(earlier, start=1):
        if isinstance(proposal, Morphology):
            lines = morphology_lines(task, proposal)
        else:
            lines = reward_lines(proposal)
        shown.append("\n".join([f"## Number {number}", *lines]))
    return render(f"diversity-{part}", count=str(len(earlier)), earlier="\n\n".join(shown))


def _improve(
    task: Task,
    part: str,
    objective: str,
    best: Evaluation,
    measured: Sequence[Evaluation],
    settings: HistorySettings,
    curve_of: CurveOf,
) -> str:
    design = best.design
    morphology, reward = morphology_lines(task, design.morphology), reward_lines(design.reward)
    volume = volume_line(task, design.morphology)
    numbers = Numbers(measured)
    if part == "morphology":
        entries = morphology_entries(task, objective, design.reward, measured, curve_of)
        improved = [*morphology, volume]
        partner = {"reward": "\n".join(reward), "partner": numbers.reward(design)}
    else:
        entries = reward_entries(task, objective, design.morphology, measured, curve_of)
        improved = reward
        partner = {
            "morphology": "\n".join([*morphology, volume]),
            "partner": numbers.morphology(design),
        }
    full = full_steps(measured)
    table = score_table(
        task,
        objective,
        measured,
        numbers,
        round(_TABLE_FRACTION * settings.tokens),
        parameters=part == "morphology",
    )
    results = render(
        "results",
        table=table,
        score=score_label(objective, task.goal),
        spread=spread_sentence(measured, objective),
        rewards="\n".join(numbers.reward_ideas()),
    )
    # What was stopped early stands in the table, which says enough about it.
    detailed = [entry for entry in entries if entry.score is None or entry.steps == full]
    left = HistorySettings(max(0, settings.tokens - estimate_tokens(table)), settings.rule)
    plural = "morphologies" if part == "morphology" else "rewards"
    if len(detailed) < len(entries):
        plural = f"fully trained or failed {plural}"
    selected = select(detailed, left, plural)
    selection = selected.selection
    if any(e.ok and e.job.steps < full for e in measured):
        selection += "\n\n" + render("fewer-steps", steps=f"{full:,}")
    return render(
        f"improve-{part}",
        best="\n".join(
            [
                *improved,
                *evaluation_lines(best, "Measured", task.goal, objective, curve=curve_of(best.key)),
            ]
        ),
        results=results,
        history=selected.entries,
        selection=selection,
        **partner,
    )
