"""A design's folder that somebody else made is refused in words, whatever is in it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from robomore.cli import inputs
from robomore.cli.trained_design import find_policies
from robomore.errors import InputError, InvalidMorphology
from robomore.tasks import get_task

SWIMMER = get_task("swimmer")
NAMES = SWIMMER.names


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[" * 200_000, "names no task"),
        ('{"task": "swimmer", "parameters":' + '{"a":' * 100_000, "names no task"),
        ("", "names no task"),
        ('{"task": 5}', "no task is called"),
        (json.dumps({"task": "swimmer", "parameters": dict.fromkeys(NAMES, 10**400)}), "too large"),
        ('{"task": "swimmer", "x": ' + "1" * 5000 + "}", "names no task"),
        ('{"task": "swimmer", "parameters": {"a": NaN}}', "unknown 'a'"),
        ('{"task": "/tmp/other/task.toml", "parameters": {}}', "no task is called"),
        ('{"task": "swimmer"}' + " " * 2**24, "more than 16,777,216 bytes"),
    ],
    ids=range(9),
)
def test_a_design_that_cannot_be_is_refused(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "design.json").write_text(text)
    with pytest.raises((InputError, InvalidMorphology), match=said) as refused:
        find_policies(tmp_path)
    assert len(str(refused.value)) < 1000


def test_a_text_without_end_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "reward.py").open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(InputError, match="more than"):
        inputs.read_text(tmp_path / "reward.py", "name another")
