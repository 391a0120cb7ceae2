"""A run as one HTML file: no request to anywhere, no script, light and dark."""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, pass_context
from jinja2.runtime import Context
from markupsafe import Markup

from robomore.errors import InvalidMorphology
from robomore.plain_files import cannot_write, write_plain
from robomore.report.command import command_line
from robomore.report.comparison_plot import parameter_rows, seed_dots
from robomore.report.heatmap import heatmap
from robomore.report.learning import learning_curves
from robomore.report.plots import best_so_far, fitness_over_volume, stage_classes
from robomore.report.source import highlighted
from robomore.runs import Run, load_run
from robomore.runs.grid import grids
from robomore.runs.words import (
    duration,
    equation,
    in_unit,
    label,
    measured,
    number,
    short,
    unit_of,
    with_interval,
)
from robomore.store import RunFolder
from robomore.text import sanitize
from robomore.types import Place

_PICTURE = (460, 340)


def write_report(run: Run | Path, out: Path | None = None) -> Path:
    """Write the page of a run; returns its path.

    Args:
        run: a run, or its folder.
        out: the file; `report.html` in the folder by default, `report-KEY.html` for one evaluation.

    Raises:
        RunFolderError: `run` is no run folder.
        InputError: the file cannot be written.
    """
    run = run if isinstance(run, Run) else load_run(run)
    usual = RunFolder(run.folder).report
    path = out or (usual.with_name(f"report-{run.focus}.html") if run.focus else usual)
    try:
        write_plain(path, sanitize(render(run)).encode())
    except OSError as error:
        raise cannot_write(path, error, "name a file with --out") from None
    return path


def render(run: Run) -> str:
    """Return the page of a run as HTML text."""
    found = grids(run)
    unit = run.fitness_unit
    # A search that was measured under its own names: dots of these stages are told apart.
    searched = {record.place.stage for record in (*run.searched, *run.cut)}
    return (
        _templates()
        .get_template("report.html")
        .render(
            run=run,
            manifest=run.manifest,
            task=run.task,
            champion=run.champion,
            reference=run.reference,
            unit=unit_of(run.objective, unit),
            grids=[(grid.stage.name, heatmap(grid, run.objective, unit)) for grid in found],
            stages={name: kind for name, kind in stage_classes(run).items() if name in searched},
            best_so_far=best_so_far(run),
            fitness_over_volume=fitness_over_volume(run),
            dots={name: seed_dots(run, name) for name in ("efficiency", "fitness")},
            curves=learning_curves(run),
            drawings=_drawings(run),
            parameters=parameter_rows(run),
            command=command_line(run.manifest),
        )
    )


@cache
def _templates() -> Environment:
    """Return the page's templates; compiling them takes longer than filling them."""
    environment = Environment(
        loader=PackageLoader("robomore.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": number,
        "short": short,
        "duration": duration,
        "label": _labelled,
        "equation": equation,
        "in_unit": in_unit,
        "measured": measured,
        "place": _described,
        "with_interval": with_interval,
        "highlighted": lambda source: Markup(highlighted(source)),
        "markup": Markup,
    }
    return environment


@pass_context
def _labelled(context: Context, name: str) -> str:
    """Return what a number of the run that is shown is called."""
    run: Run = context["run"]
    return label(name, run.fitness_unit)


@pass_context
def _described(context: Context, place: Place) -> str:
    """Return a place of the run that is shown in words."""
    run: Run = context["run"]
    return run.plan.describe(place)


def _drawings(run: Run) -> dict[str, Markup]:
    """Return the drawn champion and reference morphology, at one scale."""
    # Drawing needs the simulator; reading a run without drawing it does not.
    from robomore.rendering.drawing import draw
    from robomore.rendering.pictures import frame_around, svg

    parameters = {"reference": dict(zip(run.task.names, run.task.reference, strict=True))}
    if run.champion:
        parameters["champion"] = run.champion.parameters
    scenes = {}
    for name, values in parameters.items():
        # What an edited task trained may be refused by the task of today.
        with suppress(InvalidMorphology):
            scenes[name] = draw(run.task, values)
    return {
        name: Markup(svg(scene, frame_around(scene, *_PICTURE, alike=[*scenes.values()]), name))
        for name, scene in scenes.items()
    }
