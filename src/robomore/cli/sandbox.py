"""`robomore doctor` checks the sandbox of this machine, `robomore check-reward` checks a reward."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robomore.cli.output import console, write_json


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
    task: str,
    file: Path,
    /,
    *,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> int:
    """Check a reward for errors without running it.

    The exit status is 1 if it has an error.

    Parameters
    ----------
    task
        Id of the task that the reward is for.
    file
        A Python file that defines `_get_rew(self, x_velocity, action)`.
    as_json
        Print the findings as JSON.
    """
    from dataclasses import asdict

    from robomore.errors import InputError
    from robomore.rewards.check import check_reward as findings_of
    from robomore.tasks import get_task

    get_task(task)
    try:
        source = file.read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file} cannot be read ({error}); name a Python file") from None
    findings = findings_of(source)
    if as_json:
        write_json([asdict(finding) for finding in findings])
    else:
        for finding in findings:
            console().print(f"{file}:{finding.line}: {finding.severity}: {finding.message}")
        if not findings:
            console().print(f"{file}: no errors found")
    return 1 if any(finding.severity == "error" for finding in findings) else 0
