"""A run as one HTML file: no request to anywhere, no script, light and dark."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from robomore.errors import InputError, InvalidMorphology
from robomore.report.command import command_line
from robomore.report.comparison_plot import parameter_rows, seed_dots
from robomore.report.finalists import Contestant
from robomore.report.heatmap import heatmap
from robomore.report.plots import best_so_far, fitness_over_volume
from robomore.report.source import highlighted
from robomore.report.summary import Summary, summarise
from robomore.report.words import EFFICIENCY_UNIT, duration, number, place_name, short, with_spread
from robomore.store import RunFolder

_PICTURE = (460, 340)


def write_report(run: Path, out: Path | None = None) -> Path:
    """Write the page of a run; returns its path.

    Args:
        run: a run folder.
        out: the file; `report.html` in the folder by default.

    Raises:
        RunFolderError: `run` is no run folder.
        InputError: the file cannot be written.
    """
    summary = summarise(run)
    path = out or RunFolder(run).report
    partial = path.with_name(path.name + ".partial")
    try:
        partial.write_text(render(summary), encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        raise InputError(
            f"cannot write {path} ({error.strerror}); name a file with --out"
        ) from None
    return path


def render(summary: Summary) -> str:
    """Return the page of a run as HTML text."""
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
        "place": place_name,
        "with_spread": with_spread,
        "highlighted": lambda source: Markup(highlighted(source)),
    }
    figures = {
        "heatmap": heatmap(summary),
        "best_so_far": best_so_far(summary),
        "fitness_over_volume": fitness_over_volume(summary),
        "efficiency_dots": seed_dots(summary, "efficiency"),
        "fitness_dots": seed_dots(summary, "fitness"),
    }
    return environment.get_template("report.html").render(
        summary=summary,
        manifest=summary.manifest,
        task=summary.task,
        champion=summary.champion,
        human=summary.human,
        figures={name: Markup(drawn) for name, drawn in figures.items()},
        bodies=_bodies(summary),
        parameters=parameter_rows(summary),
        command=command_line(summary.manifest),
        unit=EFFICIENCY_UNIT,
    )


def _bodies(summary: Summary) -> dict[str, Markup]:
    """Return the drawn champion and human body, at one scale."""
    # Drawing needs the simulator; reading a run without drawing it does not.
    from robomore.rendering.drawing import draw
    from robomore.rendering.pictures import frame_around, svg

    shown: dict[str, Contestant | None] = {"champion": summary.champion, "human": summary.human}
    parameters = {
        "champion": shown["champion"].parameters if shown["champion"] else None,
        "human": dict(zip(summary.task.names, summary.task.reference, strict=True)),
    }
    scenes = {}
    for name, values in parameters.items():
        # What another version of the task trained may be refused by this one.
        with suppress(InvalidMorphology):
            if values:
                scenes[name] = draw(summary.task, values)
    return {
        name: Markup(svg(scene, frame_around(scene, *_PICTURE, alike=[*scenes.values()]), name))
        for name, scene in scenes.items()
    }
