"""Each of the paper's eight tasks."""

from __future__ import annotations

import pytest

from robomore.tasks import Task
from robomore.tasks.registry import PAPER_TASKS


@pytest.fixture(params=PAPER_TASKS, ids=lambda task: task.id)
def task(request: pytest.FixtureRequest) -> Task:
    chosen: Task = request.param
    return chosen
