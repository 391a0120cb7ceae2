"""Ids of the paper's eight tasks, whose robots are those of Gymnasium."""

from robomore.tasks.registry import PAPER_TASKS

PAPER = [task.id for task in PAPER_TASKS]
