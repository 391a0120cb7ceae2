"""The paper's eight tasks, whose robots are those of Gymnasium, and what was tried on them."""

import json
from pathlib import Path

from robomore.tasks.registry import PAPER_TASKS

PAPER = [task.id for task in PAPER_TASKS]

_FILE = Path(__file__).parent / "tasks" / "data" / "published_morphologies.json"

PUBLISHED: dict[str, list[list[float]]] = {
    id: rows for id, rows in json.loads(_FILE.read_text()).items() if id != "source"
}
"""Morphologies that a language model proposed in the paper's experiments, by the task's id."""
