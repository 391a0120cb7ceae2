"""A run as one HTML file: it carries all that it shows, and asks nobody for anything."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined, pass_context
from jinja2.runtime import Context
from markupsafe import Markup

from robomore.errors import InvalidMorphology
from robomore.options import settings_words
from robomore.plain_files import cannot_write, write_plain
from robomore.report.audit_words import in_sum
from robomore.report.command import TASK_FILE, command_line, from_task_file
from robomore.report.comparison_plot import parameter_rows, seed_dots
from robomore.report.diversity import diversity
from robomore.report.heatmap import heatmap
from robomore.report.learning import learning_curves
from robomore.report.page_data import curve_data, page_data
from robomore.report.plots import (
    best_so_far,
    fitness_over_energy,
    fitness_over_volume,
    off_the_scale,
    stage_classes,
)
from robomore.report.replays import MOST, chosen, kept_policies, recorded
from robomore.report.scripts import policy, style, with_scripts
from robomore.report.sharing import share_image
from robomore.report.source import highlighted
from robomore.runs import Run, load_run
from robomore.runs.audits import audit_of
from robomore.runs.grid import grids
from robomore.runs.pareto import in_words
from robomore.runs.scores import made_of
from robomore.runs.slimmed import over_slimmed
from robomore.runs.words import (
    duration,
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

if TYPE_CHECKING:
    from robomore.rendering.drawing import Scene

_PICTURE = (460, 340)


def write_report(run: Run | Path, out: Path | None = None, replays: int = MOST) -> Path:
    """Write the page of a run; returns its path.

    Args:
        run: a run, or its folder.
        out: the file; `report.html` in the folder by default, `report-KEY.html` for one evaluation.
        replays: designs that are shown in motion at most, champion and reference first.

    Raises:
        RunFolderError: `run` is no run folder.
        InputError: the file cannot be written.
    """
    run = run if isinstance(run, Run) else load_run(run)
    usual = RunFolder(run.folder).report
    path = out or (usual.with_name(f"report-{run.focus}.html") if run.focus else usual)
    return write_page(render(run, replays), path)


def write_page(page: str, path: Path) -> Path:
    """Write a page whole or not at all; returns its path.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        write_plain(path, page.encode())
    except OSError as error:
        raise cannot_write(path, error, "name a file with --out") from None
    return path


def render(run: Run, replays: int = MOST) -> str:
    """Return the page of a run as HTML text, with its scripts and their data."""
    # Only a page is packed: reading a run must not load the simulator.
    from robomore.rendering.packing import pack

    packs = {}
    for key, name in chosen(run, replays).items():
        if (episode := recorded(run, key, name)) is not None:
            packs[key] = episode
    if run.evaluations:
        packs["page"] = pack(page_data(run, [*packs], set(kept_policies(run))))
        packs["curves"] = pack(curve_data(run))
    # Untrusted text is cleaned here at once; what the packs hold was cleaned on its way in.
    return with_scripts(sanitize(_still_page(run, packs)), packs)


def _still_page(run: Run, packs: Mapping[str, bytes]) -> str:
    """Return the page without scripts."""
    unit = run.fitness_unit
    # A search that was measured under its own names: dots of these stages are told apart.
    searched = {record.place.stage for record in (*run.searched, *run.cut)}
    scenes = _scenes(run)
    name = run.champion.name if run.champion else "champion"
    stage = [
        (one.best(run.objective).key, said)
        for one, said in ((run.champion, name), (run.reference, "reference design"))
        if one and one.trained
    ]
    audit = audit_of(run)
    # The reference may be the champion.
    stage = [(key, said) for key, said in dict(stage).items() if key in packs]
    return (
        templates()
        .get_template("report.html")
        .render(
            run=run,
            manifest=run.manifest,
            task=run.task,
            champion=run.champion,
            reference=run.reference,
            unit=unit_of(run.objective, unit),
            compared=dict.fromkeys((run.objective, "efficiency", "fitness")),
            stage=stage,
            audit=audit,
            audited=in_sum(audit, unit) if audit else (),
            grids=[(grid.stage.name, heatmap(grid, run.objective, unit)) for grid in grids(run)],
            settings_words=settings_words(
                run.manifest.preset, run.manifest.settings, run.budget_steps
            ),
            slimmed=over_slimmed(run),
            stages={name: kind for name, kind in stage_classes(run).items() if name in searched},
            best_so_far=best_so_far(run),
            off_the_scale=off_the_scale(run),
            fitness_over_volume=fitness_over_volume(run),
            fitness_over_energy=fitness_over_energy(run),
            pareto=in_words(run),
            diversity=diversity(run),
            dots={
                name: seed_dots(run, name)
                for name in dict.fromkeys((run.objective, "efficiency", "fitness"))
            },
            curves=learning_curves(run),
            drawings=_drawings(scenes),
            parameters=parameter_rows(run),
            command=command_line(run),
            task_file=TASK_FILE if from_task_file(run) else "",
            share_image=share_image(scenes, f"{run.task.title} · RoboMoRe"),
        )
    )


@cache
def templates() -> Environment:
    """Return the templates of all pages; compiling them takes longer than filling them."""
    environment = Environment(
        loader=PackageLoader("robomore.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"style": lambda: Markup(style()), "policy": policy}
    environment.filters |= {
        "number": number,
        "short": short,
        "duration": duration,
        "label": _labelled,
        "in_unit": in_unit,
        "made_of": made_of,
        "measured": measured,
        "place": _described,
        "with_interval": with_interval,
        "highlighted": lambda source: Markup(highlighted(source)),
        "markup": Markup,
        "zip": zip,
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


def _scenes(run: Run) -> dict[str, Scene]:
    """Return champion and reference morphology at rest, as far as the task still takes them."""
    # Drawing needs the simulator; reading a run without drawing it does not.
    from robomore.rendering.drawing import draw

    parameters = {"reference": dict(zip(run.task.names, run.task.reference, strict=True))}
    if run.champion:
        parameters = {"champion": run.champion.parameters} | parameters
    scenes = {}
    for name, values in parameters.items():
        # What an edited task trained may be refused by the task of today.
        with suppress(InvalidMorphology):
            scenes[name] = draw(run.task, values)
    return scenes


def _drawings(scenes: Mapping[str, Scene]) -> dict[str, Markup]:
    """Return drawn robots at one scale."""
    from robomore.rendering.pictures import frame_around, svg

    return {
        name: Markup(svg(scene, frame_around(scene, *_PICTURE, alike=[*scenes.values()]), name))
        for name, scene in scenes.items()
    }
