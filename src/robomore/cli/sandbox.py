"""`robomore doctor` and `robomore check-reward`: containment here, and faults before training."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robomore.cli.output import console, write_json


def doctor(*, as_json: Annotated[bool, Parameter("--json", negative="")] = False) -> int:
    """Say which layers of containment are active on this machine, by trying to get past each.

    Exit status 1 if a run would refuse to start with `--containment strict`.

    Parameters
    ----------
    as_json
        Print JSON.
    """
    from dataclasses import asdict

    from robomore.sandbox.layers import layers
    from robomore.sandbox.layers import missing as missing_of

    found = layers()
    missing = [layer.name for layer in missing_of(found)]
    if as_json:
        write_json({"strict": not missing, "layers": [asdict(layer) for layer in found]})
    else:
        out = console()
        for layer in found:
            out.print(f"{'on ' if layer.active else 'OFF'}  {layer.name}: {layer.detail}")
        if missing:
            out.print(
                f"Strict containment is not possible here (no {', '.join(missing)}): "
                "`--containment relaxed` runs rewards with the layers that there are."
            )
        else:
            out.print("Strict containment is possible, and the default.")
    return 1 if missing else 0


def check_reward(
    task: str,
    file: Path,
    /,
    *,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> int:
    """Say what is wrong with a reward, without running it; exit status 1 if it has an error.

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
            console().print(f"{file}: nothing to complain about")
    return 1 if any(finding.severity == "error" for finding in findings) else 0
