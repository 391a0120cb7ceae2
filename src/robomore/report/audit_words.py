"""An audit in words: what it comes to, and as a Markdown table."""

from __future__ import annotations

from robomore.runs.words import in_unit, number
from robomore.store.audit import Audit
from robomore.text import text_only


def in_sum(audit: Audit, unit: str) -> tuple[str, ...]:
    """Return what an audit comes to, one sentence each; `unit` is that of the fitness."""
    count = len(audit.verdicts)
    if audit.passes:
        first = f"The design passes: none of {count} checks fails"
    else:
        names = ", ".join(one.check for one in audit.failed)
        first = f"The design fails {len(audit.failed)} of {count} checks: {names}"
    if audit.warned:
        first += f", {len(audit.warned)} warn"
    worth = _worth(audit.efficiency, audit.fitness, unit)
    equal = audit.equal_density
    matter = (
        f"at the reference design's density ({number(equal['density'])} kg/m³, "
        f"{number(equal['mass'])} kg)"
    )
    if "fitness" in equal:
        same = _worth(equal["efficiency"], equal["fitness"], unit)
    else:
        same = "nothing, since the physics diverges"
    return f"{first}.", f"Efficiency in the audit {worth}; {matter} {same}."


def as_markdown(audit: Audit, unit: str) -> str:
    """Return an audit as a Markdown table with two sentences below it."""
    lines = ["| verdict | check | what was seen |", "|---|---|---|"]
    lines += [
        f"| {one.outcome} | {text_only(one.check)} | {text_only(one.says)} |"
        for one in audit.verdicts
    ]
    return "\n".join([*lines, "", *(text_only(line) for line in in_sum(audit, unit)), ""])


def _worth(efficiency: float | None, fitness: float | None, unit: str) -> str:
    return f"{in_unit(efficiency, 'efficiency', unit)} ({in_unit(fitness, 'fitness', unit)})"
