"""A ledger of many evaluations, written row by row: nothing is trained."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from fake_run import NASTY, SETTINGS, FakeRun
from robomore.store import Ledger
from robomore.types import Curve, Design, MethodSettings, Morphology, Place, Reward, Status

_POINTS = 64


def large_run(path: Path, rows: int = 50, columns: int = 40) -> FakeRun:
    """Write a finished run of the method `robomore` with a grid of `rows` x `columns` pairs.

    Every pair has a learning curve of full length with ten series; every hundredth one failed.
    """
    options = {"morphologies": rows, "rewards": columns, "survivors": 0.001, "max_cycles": 1}
    settings = replace(SETTINGS, method=MethodSettings("robomore", options))
    run = FakeRun(path, settings=settings)
    first = run.add(run.reference, Place(stage="coarse", index=(0, 0)), 12.0)
    with closing(Ledger(run.folder.ledger)) as ledger:
        for number in range(1, rows * columns):
            row, column = divmod(number, columns)
            shrink = 1 - 0.75 * row / rows
            design = Design(
                Morphology(run.morphology(shrink).parameters, f"idea {row}"),
                Reward(run.reward(1.0 + column).source + f"    # {NASTY} {column}\n"),
            )
            job = replace(first.job, design=design, seed=number)
            place = Place(stage="coarse", index=(row, column))
            key = f"pair{number:05d}"
            ledger.add_place(place, key)
            if number % 100 == 7:
                failed = replace(
                    first, key=key, job=job, status=Status.REWARD_FAILED, diagnosis=NASTY,
                    fitness=None, volume=None, efficiency=None, episode_fitness=(),
                )  # fmt: skip
                ledger.add_evaluation(failed)
                continue
            volume = run.task.volume(design.morphology.parameters)
            fitness = 5.0 + (number * 7919 % 1000) / 50
            ledger.add_evaluation(
                replace(
                    first,
                    key=key,
                    job=job,
                    fitness=fitness,
                    volume=volume,
                    efficiency=fitness / volume,
                    behaviour=first.behaviour | {"energy_j": 100.0 + fitness * (1 + row)},
                    curve=_curve(number),
                )
            )
    run.final(first)
    return run


def _curve(number: int) -> Curve:
    names = ["episode_return", "episode_length", "loss/critic", "loss/actor", "alpha"]
    names += [f"term/part {part}" for part in range(5)]
    return Curve(
        tuple(1000 * (i + 1) for i in range(_POINTS)),
        {
            name: tuple((hash_of(number, i, n) % 100_000) / 997 - 50 + i for i in range(_POINTS))
            for n, name in enumerate(names)
        },
    )


def hash_of(*numbers: int) -> int:
    """Return a number that looks random, the same in every process."""
    found = 17
    for number in numbers:
        found = (found * 1_000_003 + number * 7919) % 2**31
    return found
