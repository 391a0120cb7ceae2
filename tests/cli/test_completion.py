"""A shell completes the names of tasks, presets and methods."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from cli.commands import Command
from robomore.search import METHODS
from robomore.settings import PRESETS
from robomore.tasks import TASKS


@pytest.mark.parametrize(
    ("words", "names"),
    [
        ("run", TASKS),
        ("inspect", TASKS),
        ("run ant --preset", PRESETS),
        ("run ant --method", METHODS),
    ],
)
def test_names_are_completed(words: str, names: Iterable[str], robomore_: Command) -> None:
    said = robomore_("__complete", *words.split(), "")
    assert set(names) <= {line.partition("\t")[0] for line in said.out.splitlines()}
