"""What a designer says to a language model: the texts in `prompts/`, filled in.

Everything here is a pure function of task, settings and what was measured, so what is printed by
`robomore prompt` is what is sent.
"""

from __future__ import annotations

import json
import string
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

from robomore.designers.llm import formatting as telling
from robomore.designers.llm import history
from robomore.designers.llm.history import HistorySettings
from robomore.errors import InputError
from robomore.llm.model import Message
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward

KINDS = ("morphology", "reward", "improve-morphology", "improve-reward")

_FITNESS = {
    "distance": "how far the torso gets in the direction of +x in an episode, in m, as a mean over "
    "several episodes",
    "height": "the greatest height of the torso in an episode, in m, as a mean over several "
    "episodes",
}
_OBJECTIVES = {
    "efficiency": "The score is the efficiency. Make it as high as you can.",
    "fitness": "The score is the fitness. Make it as high as you can.",
}


def render_prompt(
    task: Task,
    kind: str,
    *,
    objective: str = "efficiency",
    earlier: Sequence[Morphology | Reward] = (),
    best: Evaluation | None = None,
    measured: Sequence[Evaluation] = (),
    settings: HistorySettings | None = None,
) -> list[Message]:
    """Return the conversation that asks for one proposal.

    Args:
        task: what is to be done.
        kind: one of `KINDS`.
        objective: what the search compares, `efficiency` or `fitness`.
        earlier: proposals to differ from (Diversity Reflection), for the first two kinds.
        best: what is to be improved on, for the other two.
        measured: the history, for the other two.
        settings: of the history.

    Raises:
        InputError: no such kind, or nothing to improve on.
    """
    if kind not in KINDS:
        raise InputError(f"unknown prompt {kind!r}; choose one of {', '.join(KINDS)}")
    half = kind.removeprefix("improve-")
    parts = [_base(task, half, objective)]
    if kind != half:
        if best is None:
            raise InputError(f"the prompt {kind!r} improves on something measured: name a run")
        parts.append(_improve(task, half, objective, best, measured, settings or HistorySettings()))
    elif earlier:
        parts.append(_diversity(task, half, earlier))
    return [
        Message("system", render(f"role-{half}")),
        Message("user", "\n\n".join(parts)),
    ]


def repair_message(faults: Sequence[str]) -> Message:
    """Return what is answered to a reply with `faults`."""
    return Message("user", render("repair", faults="\n".join(f"- {fault}" for fault in faults)))


def morphology_schema(task: Task) -> dict[str, Any]:
    """Return the JSON schema of a morphology, every number within its bounds."""
    numbers = {
        p.name: {"type": "number", "minimum": p.low, "maximum": p.high} for p in task.parameters
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
        KeyError: the file has a field that is not given.
        ValueError: a field is given that the file lacks.
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


def _base(task: Task, half: str, objective: str) -> str:
    shared = {
        "description": task.description,
        "episode_steps": f"{task.episode_steps:,}",
        "fitness": _FITNESS[task.fitness],
        "objective": _OBJECTIVES[objective],
    }
    if half == "reward":
        # Imported here because it reads the simulator's classes, which nothing else here needs.
        from robomore.envs.source import environment_source

        return render("reward", environment=environment_source(task).strip(), **shared)
    return render(
        "morphology",
        mjcf=task.masked_mjcf.strip(),
        parameters=_table(task),
        rules=_rules(task),
        form=_form(task),
        count=str(len(task.parameters)),
        **shared,
    )


def _table(task: Task) -> str:
    rows = [
        f"| {p.name} | {p.meaning} | {p.unit} | {p.low:g} | {p.high:g} |" for p in task.parameters
    ]
    head = ["| name | meaning | unit | least | most |", "|---|---|---|---|---|"]
    return "\n".join([*head, *rows])


def _rules(task: Task) -> str:
    if not task.rules:
        return "Any numbers within these bounds make a body."
    rules = [f"- {rule.text}" for rule in task.rules]
    return "\n".join(["Besides, a body has to keep to these rules:", "", *rules])


def _form(task: Task) -> str:
    names = ", ".join(f"{json.dumps(name)}: …" for name in task.names)
    return f'{{"parameters": {{{names}}}, "description": "…"}}'


def _diversity(task: Task, half: str, earlier: Sequence[Morphology | Reward]) -> str:
    told = []
    for number, proposal in enumerate(earlier, start=1):
        if isinstance(proposal, Morphology):
            lines = telling.body(task, proposal)
        else:
            lines = telling.program(proposal)
        told.append("\n".join([f"## Number {number}", *lines]))
    return render(f"diversity-{half}", count=str(len(earlier)), earlier="\n\n".join(told))


def _improve(
    task: Task,
    half: str,
    objective: str,
    best: Evaluation,
    measured: Sequence[Evaluation],
    settings: HistorySettings,
) -> str:
    design = best.design
    result = telling.result(best, "Measured")
    full = history.full_steps(measured)
    fewer = ""
    if any(e.ok and e.job.steps < full for e in measured):
        fewer = "\n\n" + render("fewer-steps", steps=f"{full:,}")
    if half == "morphology":
        told = history.tell(
            history.bodies(task, objective, design.reward, measured), settings, "bodies"
        )
        return render(
            "improve-morphology",
            best="\n".join([*telling.body(task, design.morphology), *result]),
            reward=design.reward.source.strip(),
            history=told.entries,
            selection=told.selection + fewer,
        )
    told = history.tell(
        history.rewards(objective, design.morphology, measured), settings, "rewards"
    )
    return render(
        "improve-reward",
        best="\n".join([*telling.program(design.reward), *result]),
        body="\n".join(telling.body(task, design.morphology)),
        history=told.entries,
        selection=told.selection + fewer,
    )
