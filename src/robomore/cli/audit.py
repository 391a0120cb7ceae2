"""`robomore audit`: whether a design's number is worth believing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robomore.cli.output import console, write, write_json
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.store.audit import Audit

_COLOURS = {"passes": "green", "warns": "yellow", "fails": "bold red", "skipped": "dim"}


def audit(
    design: Path,
    /,
    *,
    evaluation: str | None = None,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
    markdown: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Check whether a champion's number comes from the robot, or from a fault of the simulator.

    Its policy runs again with other numerics, noise, pushes and other matter. Nothing is trained.
    The audit is kept beside the policy, as `audit.json`. Exits with status 1 if a check fails.

    Parameters
    ----------
    design
        A run's folder, or a folder with `design.json` and `policy.npz`.
    evaluation
        Key of one of the run's evaluations, or its beginning, instead of the champion.
    as_json
        Print JSON, with every digit.
    markdown
        Print a Markdown table.
    """
    from robomore.report.audit_words import as_markdown
    from robomore.store import RunFolder

    if as_json and markdown:
        raise InputError("give --json or --markdown, not both")
    if RunFolder(design).manifest.is_file():
        from robomore.experiment.auditing import audit_run
        from robomore.runs.loading import stored_task

        found = audit_run(design, evaluation)
        task = stored_task(RunFolder(design).files, found.task)
    else:
        from robomore.cli.trained_design import find_policies
        from robomore.experiment.auditing import audit_design

        (one,) = find_policies(design, evaluation)
        task = one.task
        found = audit_design(one.folder, task, one.parameters, one.policy)
    if as_json:
        write_json(found.as_data())
    elif markdown:
        write(as_markdown(found, task.goal.unit))
    else:
        print_audit(found, task.goal.unit)
    return 0 if found.passes else 1


def print_audit(found: Audit, unit: str) -> None:
    """Print the verdicts as a table, and what they come to; `unit` is that of the fitness."""
    from rich.table import Table

    from robomore.report.audit_words import in_sum

    screen = console()
    table = Table(box=None, pad_edge=False, show_header=False)
    for _ in range(3):
        table.add_column()
    for one in found.verdicts:
        table.add_row(one.outcome, one.check, one.says, style=_COLOURS[one.outcome])
    screen.print(table)
    screen.print()
    for line in in_sum(found, unit):
        screen.print(line)
