"""Runs that differ in nothing but their seed, which alone a mean may be taken over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robomore.options import settings_words
from robomore.runs import Run
from robomore.runs.words import unit_of
from robomore.text import one_line, to_json

_COLOURS = 6


@dataclass(frozen=True, slots=True)
class Group:
    """The runs of one method on one task, asked for alike.

    Attributes:
        task: title of the task.
        name: of the method, with the designer, and with what tells it from others of that name.
        kind: classes of its colour and dashes.
        runs: with different seeds.
    """

    task: str
    name: str
    kind: str
    runs: tuple[Run, ...]

    @property
    def objective(self) -> str:
        """What all its runs compared."""
        return self.runs[0].objective

    @property
    def unit(self) -> str:
        """Unit of what they compared."""
        return unit_of(self.objective, self.runs[0].fitness_unit)


def run_groups(runs: Sequence[Run]) -> list[Group]:
    """Return runs by task and by all that was asked for but the seed.

    Fitness and efficiency, `quick` and `standard`, or two language models have no mean in common.
    """
    found: dict[tuple[str, str, tuple[str, ...]], list[Run]] = {}
    for run in runs:
        found.setdefault((run.task.title, _name(run), _asked(run)), []).append(run)
    called: dict[tuple[str, tuple[str, ...]], str] = {}
    for base in dict.fromkeys(name for _, name, _ in found):
        alike = {asked: those[0] for (_, name, asked), those in found.items() if name == base}
        called |= {(base, asked): told for asked, told in _told_apart(base, alike).items()}
    names = list(dict.fromkeys(called[name, asked] for _, name, asked in found))
    return [
        Group(task, called[name, asked], _kind(names.index(called[name, asked])), tuple(those))
        for (task, name, asked), those in found.items()
    ]


def _of_a_study(run: Run) -> bool:
    return run.folder.parent.name == "cells"


def _name(run: Run) -> str:
    """Return the method with its designer, or the arm of a study, which its folder names."""
    manifest = run.manifest
    name = manifest.settings.method.name
    name += f", {manifest.designer}" if manifest.designer else ""
    if _of_a_study(run):
        name = run.folder.name.removeprefix(f"{manifest.task}-").rpartition("-s")[0] or name
    return name


def _asked(run: Run) -> tuple[str, ...]:
    """Return all that was asked for but task and seed, to be compared."""
    manifest = run.manifest
    # In a study, each seed may start from what the same seed found elsewhere.
    starts = () if _of_a_study(run) else tuple(one.content for one in manifest.starts)
    parts = (manifest.settings, run.budget_steps, manifest.designer_settings, starts)
    return (run.fitness_unit, *(to_json(part).decode() for part in parts))


def _told_apart(base: str, alike: dict[tuple[str, ...], Run]) -> dict[tuple[str, ...], str]:
    """Return a name for each way of asking; only what differs is added to `base`."""
    said = {asked: _words(run) for asked, run in alike.items()}
    differing = [
        place
        for place in range(len(next(iter(said.values()))))
        if len({words[place] for words in said.values()}) > 1
    ]
    names: dict[tuple[str, ...], str] = {}
    for asked, words in said.items():
        name = ", ".join([base, *(words[place] for place in differing if words[place])])
        # Settings that have no words: of nobody's preset, for example.
        count = list(names.values()).count(name)
        names[asked] = f"{name} ({count + 1})" if count else name
    return names


def _words(run: Run) -> tuple[str, ...]:
    manifest = run.manifest
    origins = ", ".join(one_line(start.origin) for start in manifest.starts)
    return (
        settings_words(manifest.preset, manifest.settings, run.budget_steps),
        one_line(str(manifest.designer_settings.get("model", ""))),
        f"from {origins}" if origins else "",
    )


def _kind(number: int) -> str:
    """Return the classes of a method's line: a colour, and dashes where colours come again."""
    return f"term-{number % _COLOURS}" + (" again" if number >= _COLOURS else "")
