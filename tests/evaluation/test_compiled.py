"""Compiled trainers are kept for all who come later, and damaged ones are made again."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.evaluation.compiled import compiled_trainer
from robomore.sandbox.call import Containment
from robomore.training.compilation import CACHE_VARIABLE, is_damaged
from robomore.training.warm import Shape
from robomore.types import TrainerSettings

SHAPE = Shape(TrainerSettings("crossq", {"net_arch": [4], "batch_size": 4, "num_envs": 2}), 3, 2)


def test_a_damaged_program_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    folder = compiled_trainer(SHAPE, Containment.RELAXED)
    assert folder is not None
    programs = sorted(folder.iterdir())
    times = [program.stat().st_mtime_ns for program in programs]
    assert compiled_trainer(SHAPE, Containment.RELAXED) == folder
    assert [program.stat().st_mtime_ns for program in programs] == times

    content = programs[0].read_bytes()
    programs[0].write_bytes(content[:1000] + bytes(64) + content[1064:])
    assert is_damaged(folder)
    assert compiled_trainer(SHAPE, Containment.RELAXED) == folder
    assert sorted(folder.iterdir()) == programs and not is_damaged(folder)
    assert list(tmp_path.iterdir()) == [folder], "nothing is left of the damaged ones"
