"""`robomore study`: a grid of runs with tables and figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from robomore.cli.completion import PRESET, TASK
from robomore.cli.inputs import positive
from robomore.cli.llm import ModelOptions, ReplayOptions, chosen
from robomore.cli.output import console, tell, write
from robomore.cli.run_options import Machine
from robomore.cli.whole import Whole
from robomore.errors import InputError


def study(
    name: str | None = None,
    /,
    *tasks: Annotated[str, TASK],
    preset: Annotated[str, PRESET] = "quick",
    seeds: Whole | None = None,
    arm: Annotated[list[str] | None, Parameter(negative="")] = None,
    designer: Annotated[str | None, Parameter(group=Group("Designer", sort_key=4))] = None,
    model: ModelOptions | None = None,
    replay: ReplayOptions | None = None,
    machine: Machine | None = None,
    side_by_side: Whole | None = None,
    plan: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Run a study: several methods or settings on several tasks, with tables and figures.

    Each run's result is told as it ends, with about how long all of them still take. The same
    command again finishes a study that was stopped. Without a name, the studies are listed.

    Parameters
    ----------
    name
        Name of a study.
    tasks
        Ids of tasks, or paths of task files (.toml); by default those of the study.
    preset
        How large the runs are: `smoke`, `quick`, `standard` or `paper`.
    seeds
        Runs of each arm on each task; by default as many as the preset says.
    arm
        Only this arm of the study. May be given several times.
    designer
        Who proposes in the arms that ask a designer: `offline` (the default), `llm` or `replay`.
    side_by_side
        Runs at the same time, which fill each other's gaps; by default one, and on a Ray cluster
        as many as it has workers. The numbers do not depend on it.
    plan
        List the runs and the most control steps that they take, and start nothing.
    """
    from robomore.cli.study_progress import StudyProgress
    from robomore.studies import STUDIES, run_study
    from robomore.studies.execute import cells_of
    from robomore.studies.presets import scale

    if name is None:
        screen = console()
        for known, found in STUDIES.items():
            screen.print(known, style="bold", end="")
            screen.print(f"  {found.summary}")
            screen.print(f"  {', '.join(one.name for one in found.arms)}", markup=False)
        return
    wanted = STUDIES.get(name)
    machine = machine or Machine()
    machine.check()
    positive(side_by_side=side_by_side)
    size = scale(preset)
    cells = cells_of(wanted, tasks, size, size.seeds if seeds is None else seeds)
    if arm:
        if unknown := sorted(set(arm) - {one.name for one in wanted.arms}):
            raise InputError(
                f"{name} has no arm {', '.join(map(repr, unknown))}; it has "
                f"{', '.join(one.name for one in wanted.arms)}"
            )
        cells = [cell for cell in cells if cell.arm.name in arm]
        if not cells:
            raise InputError(
                f"--arm {' --arm '.join(arm)} changes nothing at the preset {preset}, so there is "
                "nothing to compare; name another --preset or --arm"
            )
    else:
        used = {cell.arm.name for cell in cells}
        if same := [one.name for one in wanted.arms if one.name not in used]:
            tell(f"left out, the same as another arm at this preset: {', '.join(same)}\n")
    if plan:
        for cell in cells:
            write(f"{cell.folder.name}\n")
        search, final = (sum(cell.most_steps[part] for cell in cells) for part in (0, 1))
        runs = f"{len(cells)} run{'' if len(cells) == 1 else 's'}"
        write(
            f"{runs}, at most {search + final:,} control steps: {search:,} of search and "
            f"{final:,} of finals\n"
        )
        return
    out = machine.out or Path("studies") / f"{name}-{preset}"
    proposing = chosen(designer, model, replay)
    with machine.opened() as executor:
        at_once = 1 if isinstance(executor, str) else executor.workers
        at_once = side_by_side or min(len(cells), at_once)
        progress = StudyProgress(cells, at_once, tell)
        results = run_study(
            wanted,
            cells,
            out,
            designer=proposing,
            executor=executor,
            workers=machine.workers,
            containment=machine.containment,
            side_by_side=at_once,
            tell=progress.begin,
            measuring=progress.measure,
            ended=progress.end,
        )
    for table in wanted.told(results):
        write(f"{table.markdown()}\n")
    write(f"tables and figures: {out}\n")
