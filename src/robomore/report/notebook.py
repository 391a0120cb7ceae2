"""A run as a notebook shows it: champion and reference in numbers, and moving."""

from __future__ import annotations

import base64
import logging
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from robomore.errors import InvalidMorphology, RoboMoReError
from robomore.rendering.drawing import draw
from robomore.rendering.pictures import frame_around, svg
from robomore.rendering.recording import record
from robomore.rendering.video import write_video
from robomore.runs import Run, TrainedDesign
from robomore.runs.words import number, unit_of, with_interval
from robomore.tasks import Task
from robomore.text import sanitize

_SECONDS = 3.0
_PICTURE = (320, 240)

_MOST_KEPT = 8
_MADE: dict[tuple[object, ...], bytes] = {}

log = logging.getLogger(__name__)


def notebook_html(run: Run) -> str:
    """Return a run as a piece of HTML that needs nothing from outside and holds no script.

    Where policies are there, the designs move; else they stand still.
    """
    manifest = run.manifest
    designs = [one for one in (run.champion, run.reference) if one is not None]
    state = "finished" if run.found else "not finished"
    head = (
        f"{run.task.title}, method {manifest.settings.method.name}, seed {manifest.seed}, {state}"
    )
    parts = [f"<p><strong>{_text(head)}</strong></p>"]
    if designs:
        parts += [_table(run, designs), _moving(run, designs)]
    parts += [f"<p>{_text(said)}</p>" for said in run.warnings[:3]]
    return f"<div>{''.join(parts)}</div>"


def _table(run: Run, designs: list[TrainedDesign]) -> str:
    rows = [("", *(one.name for one in designs))]
    for name in dict.fromkeys((run.objective, "efficiency", "fitness")):
        unit = unit_of(name, run.fitness_unit)
        spreads = [one.score(name) for one in designs]
        rows.append(
            (name.replace("-", " "), *(with_interval(one, unit) if one else "-" for one in spreads))
        )
    rows.append(("volume", *(f"{number(one.volume)} m³" for one in designs)))
    lines = ("".join(f"<td>{_text(cell)}</td>" for cell in row) for row in rows)
    return f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def _moving(run: Run, designs: list[TrainedDesign]) -> str:
    """Return a replay of those designs that have a policy, or still pictures."""
    trained = [one for one in designs if one.trained]
    if not trained:
        return "".join(_still(run.task, one) for one in designs)
    keys = tuple(one.best(run.objective).key for one in trained)
    names = " above, ".join(one.name for one in trained)
    try:
        content = _replay(run, keys, tuple(one.name for one in trained))
    except RoboMoReError as error:
        log.info("no replay: %s", error)
        return "".join(_still(run.task, one) for one in designs)
    source = base64.b64encode(content).decode()
    return f'<img alt="{_text(names)}, moving" src="data:image/webp;base64,{source}">'


def _replay(run: Run, keys: tuple[str, ...], names: tuple[str, ...]) -> bytes:
    """Return a video of policies, made once for each: a notebook shows a run again and again."""
    which = (run.folder.resolve(), *keys)
    if which in _MADE:
        return _MADE[which]
    recordings = []
    for key, name in zip(keys, names, strict=True):
        parameters = run.evaluation(key).design.morphology.parameters
        act = run.load_policy(key).act
        recordings.append(record(run.task, parameters, act, name).first(_SECONDS))
    with TemporaryDirectory(prefix="robomore-") as scratch:
        path = Path(scratch) / "replay.webp"
        write_video(recordings, path, _SECONDS, drawn=True)
        if len(_MADE) >= _MOST_KEPT:
            _MADE.pop(next(iter(_MADE)))
        _MADE[which] = path.read_bytes()
    return _MADE[which]


def _still(task: Task, design: TrainedDesign) -> str:
    try:
        scene = draw(task, design.design.morphology.parameters)
    except InvalidMorphology:  # what an edited task trained, the task of today may refuse
        return ""
    picture = svg(scene, frame_around(scene, *_PICTURE), design.name)
    return f'<span style="display:inline-block;width:{_PICTURE[0]}px">{picture}</span>'


def _text(text: str) -> str:
    return escape(sanitize(text))
