"""`robomore doctor` checks the sandbox of this machine, `robomore check-reward` checks a reward."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from robomore.cli.completion import TASK
from robomore.cli.output import console, write_json

if TYPE_CHECKING:
    from robomore.rewards.dry_run import DryRunResult
    from robomore.rewards.dry_run_findings import Observed, Term
    from robomore.rewards.finding import Finding


def doctor(*, as_json: Annotated[bool, Parameter("--json", negative="")] = False) -> int:
    """Check which sandbox layers this machine offers.

    Each layer is turned on in a process that then tries to get past it. The exit status is 1 if a
    run with `--containment strict` would refuse to start on this machine.

    Parameters
    ----------
    as_json
        Print JSON.
    """
    from dataclasses import asdict

    from robomore.sandbox.layers import layers
    from robomore.sandbox.restrictions import missing

    found = layers()
    lacking = [layer.name for layer in missing(found)]
    if as_json:
        write_json({"strict": not lacking, "layers": [asdict(layer) for layer in found]})
    else:
        out = console()
        for layer in found:
            out.print(f"{'on ' if layer.active else 'OFF'}  {layer.name}: {layer.detail}")
        if lacking:
            out.print(
                "Strict containment is not possible on this machine, because a required layer is "
                f"missing: {', '.join(lacking)}. With `--containment relaxed`, rewards run with "
                "the layers that are available."
            )
        else:
            out.print("Strict containment, the default, is possible on this machine.")
    return 1 if lacking else 0


def check_reward(
    task: Annotated[str, TASK],
    file: str,
    /,
    *,
    containment: Literal["strict", "relaxed"] | None = None,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> int:
    """Check a reward: read its text, then try it out on moving robots in the sandbox.

    Prints findings with their lines, statistics of the terms and the cost of a call, and at the end
    whether the reward is accepted. A reward of a language model gets the same check and the same
    dry run. The exit status is 1 if there is an error.

    Parameters
    ----------
    task
        Id of the task that the reward is for, or the path of its task file (.toml).
    file
        A Python file that defines `_get_rew(self, x_velocity, action)`, or `reference` for the
        task's own reward.
    containment
        `strict` does not try the reward out where the machine lacks a sandbox layer, `relaxed` uses
        the layers that are there. Default: `strict`.
    as_json
        Print findings and statistics as JSON.
    """
    from dataclasses import asdict
    from tempfile import TemporaryDirectory

    from robomore.cli.inputs import REFERENCE, read_text
    from robomore.experiment.containing import choose_containment
    from robomore.rewards.check import check_reward as findings_of
    from robomore.rewards.dry_run import DryRun, DryRunResult
    from robomore.tasks import get_task

    chosen = get_task(task)
    remedy = f"name a Python file, or `{REFERENCE}` for the task's own reward"
    source = chosen.reward if file == REFERENCE else read_text(Path(file), remedy)
    findings = findings_of(source)
    result = DryRunResult([])
    if not any(finding.severity == "error" for finding in findings):
        mode, _ = choose_containment(containment, ours=False)
        with TemporaryDirectory() as scratch:
            result = DryRun(chosen, Path(scratch), mode).result(source)
    findings = [*findings, *result.findings]
    if as_json:
        observed = asdict(result.observed) if result.observed else None
        write_json({"findings": [asdict(it) for it in findings], "observed": observed})
    else:
        screen = console()
        for finding in findings:
            said = f"{file}:{finding.line}: {finding.severity}: {finding.message}"
            screen.print(said, markup=False, highlight=False)
        if result.observed:
            _print_statistics(result.observed)
        screen.print(f"{file}: {_verdict(result, findings)}", markup=False, highlight=False)
    return 0 if _accepted(result, findings) else 1


def _accepted(result: DryRunResult, findings: Sequence[Finding]) -> bool:
    """Whether a reward was tried out and has no error.

    Without a dry run, because the machine could not do one, nothing is known of the reward.
    """
    return result.observed is not None and all(one.severity != "error" for one in findings)


def _verdict(result: DryRunResult, findings: Sequence[Finding]) -> str:
    """Return in one line whether a reward can be trained, and how much was found."""
    counts = Counter(one.severity for one in findings)
    found = [
        f"{counts[kind]} {kind}{'s' if counts[kind] > 1 else ''}"
        for kind in ("error", "warning", "note")
        if counts[kind]
    ]
    listed = " and ".join([", ".join(found[:-1]), found[-1]] if len(found) > 1 else found)
    if counts["error"]:
        return f"refused, with {listed}"
    if not _accepted(result, findings):
        return "neither accepted nor refused: it could not be tried out"
    return f"accepted, with {listed}" if found else "accepted"


def _print_statistics(observed: Observed) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    table.add_column("term")
    for heading in ("mean", "low", "high", "std"):
        table.add_column(heading, justify="right")
    rows: list[tuple[str, Observed | Term]] = [("(the reward)", observed)]
    for name, term in (*rows, *observed.terms.items()):
        numbers = (term.mean, term.low, term.high, term.spread)
        table.add_row(Text(name), *(f"{number:.4g}" for number in numbers))
    console().print(table)
    console().print(
        f"{observed.calls} calls on robots that moved at random; one call takes "
        f"{1e6 * observed.seconds:.0f} µs of processor time"
    )
