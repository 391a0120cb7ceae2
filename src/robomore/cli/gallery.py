"""`robomore gallery`: champions of many runs, each in a small folder of its own."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from robomore.cli.output import beginning, console, tell, write, write_json
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.runs.gallery import Entry


def gallery(*runs: Path, out: Path) -> None:
    """Copy the champions of runs into a gallery, which `robomore show` reads.

    Each takes a folder with parameters, reward, policy and audit. A champion that was not audited
    is audited first, which takes about a minute.

    Parameters
    ----------
    runs
        Folders of finished runs.
    out
        Folder of the gallery, made if it is not there. What is in it stays.
    """
    from robomore.experiment.auditing import audit_run
    from robomore.runs import load_run
    from robomore.runs.audits import audit_of
    from robomore.runs.gallery import add_entry

    if not runs:
        raise InputError("no run was named; give the folders of finished runs")
    for path in runs:
        found = load_run(path)
        if found.final and audit_of(found) is None:
            tell(f"auditing {path}\n")
            audit_run(path)
        write(f"{add_entry(found, out)}\n")


def show_gallery(folder: Path, as_json: bool) -> None:
    """Print a table of the champions in a gallery."""
    from rich.table import Table

    from robomore.runs.gallery import load_gallery
    from robomore.runs.words import in_unit, number

    entries = load_gallery(folder)
    if as_json:
        write_json([_data(one) for one in entries])
        return
    table = Table(box=None, pad_edge=False)
    table.add_column("champion")
    table.add_column("task")
    for heading in ("efficiency", "fitness", "volume m³", "over reference"):
        table.add_column(heading, justify="right")
    table.add_column("kept at equal density", justify="right")
    table.add_column("audit")
    for one in entries:
        table.add_row(
            one.folder.name,
            one.task.title,
            in_unit(one.efficiency, "efficiency", one.task.goal.unit),
            in_unit(one.fitness, "fitness", one.task.goal.unit),
            number(one.facts.volume),
            _over_reference(one),
            _kept(one),
            _verdict(one),
        )
    console().print(table)


def show_entry(folder: Path, as_json: bool) -> None:
    """Print one champion: numbers, parameters, reward, origin and audit."""
    from rich.table import Table

    from robomore.cli.audit import print_audit
    from robomore.runs.gallery import load_entry
    from robomore.runs.words import in_unit, number

    one = load_entry(folder)
    if as_json:
        write_json(_data(one))
        return
    screen = console()
    screen.print(f"{one.task.title}: {one.folder.name}", style="bold")
    if one.origin is not None:
        origin = one.origin
        designer = f", designer {origin.designer}" if origin.designer else ""
        settings = origin.settings or f"preset {origin.preset}"
        screen.print(
            f"{settings}; method {origin.method}{designer}, seed {origin.seed}; "
            f"trained for {origin.steps:,} steps with {len(one.facts.seeds)} seeds"
        )
        screen.print(origin.provenance)
        if origin.containment:
            screen.print(f"Containment was {origin.containment}.")
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column()
    table.add_column(justify="right")
    unit = one.task.goal.unit
    table.add_row("efficiency", in_unit(one.efficiency, "efficiency", unit))
    table.add_row("over the reference design", _over_reference(one))
    table.add_row("fitness", in_unit(one.fitness, "fitness", unit))
    table.add_row("volume m³", number(one.facts.volume))
    for parameter in one.task.parameters:
        value = number(one.facts.parameters[parameter.name])
        table.add_row(f"{parameter.name} {parameter.unit}", value)
    screen.print(table)
    screen.print()
    screen.print(beginning(one.reward.rstrip(), f"`robomore show {quote(str(folder))} --json`"))
    screen.print()
    if one.audit is None:
        screen.print("It is not audited.")
    else:
        print_audit(one.audit, unit)


def _over_reference(one: Entry) -> str:
    """Return the ratio in what the run compared; its name where that is not efficiency."""
    from robomore.runs.words import number

    origin = one.origin
    scores = origin.final_score if origin else {}
    if origin is None or origin.objective in ("", "efficiency") or not scores.get(origin.role):
        reference = origin.reference_efficiency if origin else ()
        mean = sum(reference) / len(reference) if reference else 0.0
        above = one.efficiency
        return number(above / mean if above is not None and mean > 0 else None, 3)
    reference, own = scores.get("reference", ()), scores[origin.role]
    mean = sum(reference) / len(reference) if reference else 0.0
    ratio = sum(own) / len(own) / mean if mean > 0 else None
    return f"{number(ratio, 3)} ({origin.objective.replace('-', ' ')})"


def _kept(one: Entry) -> str:
    """Return what is left of the audit's efficiency with the reference design's matter."""
    from robomore.runs.words import measured

    whole = one.audit.efficiency if one.audit else None
    equal = one.audit.equal_density.get("efficiency") if one.audit else None
    if whole is None or whole <= 0 or equal is None:
        return "-"
    return measured("kept_share", equal / whole)


def _verdict(one: Entry) -> str:
    if one.audit is None:
        return "not audited"
    if not one.audit.passes:
        return f"fails: {', '.join(verdict.check for verdict in one.audit.failed)}"
    return f"passes, {len(one.audit.warned)} warn" if one.audit.warned else "passes"


def _data(one: Entry) -> dict[str, Any]:
    import msgspec

    return {
        "name": one.folder.name,
        **msgspec.to_builtins(one.facts),
        "reward": one.reward,
        "origin": msgspec.to_builtins(one.origin),
        "audit": one.audit.as_data() if one.audit else None,
    }
