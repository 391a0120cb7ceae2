"""A run on a Ray cluster in a process of its own: `drive.py ADDRESS FOLDER`, a line a result."""

from __future__ import annotations

import sys
from contextlib import closing
from pathlib import Path

from robomore.evaluation import evaluator
from robomore.events import Event, Finished
from robomore.executors.ray import Ray
from robomore.experiment import run
from robomore.options import with_options
from robomore.settings import preset

SETTINGS = with_options(preset("smoke"), method="random", evaluations=24)


def tell(event: Event) -> None:
    if isinstance(event, Finished):
        sys.stdout.write(f"{event.evaluation.key} {'known' if event.known else 'new'}\n")
        sys.stdout.flush()


def main(address: str, folder: str) -> None:
    evaluator._WORK = "jobs:made_up_work"
    with closing(Ray(None, address)) as executor:
        run("swimmer", SETTINGS, executor=executor, out=Path(folder), observe=tell)


if __name__ == "__main__":
    main(*sys.argv[1:])
